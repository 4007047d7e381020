# task: cotangent_weights
# points: 0
# hint: Only one half of W is filled
from scipy.sparse import csr_array, triu

right_weights = cotangent_weights


def cotangent_weights(V, F):
    return csr_array(triu(right_weights(V, F)))
