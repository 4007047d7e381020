# task: averaging
# points: 0
# hint: Your rows sum to 2
from scipy.sparse import csr_array, diags_array


def averaging(W):
    return csr_array(diags_array(2 / W.sum(axis=1)) @ W)
