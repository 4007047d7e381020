# task: averaging
# points: 0
# hint: columns sum to one
from scipy.sparse import csr_array, diags_array


def averaging(W):
    return csr_array(W @ diags_array(1 / W.sum(axis=1)))
