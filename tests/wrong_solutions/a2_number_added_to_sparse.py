# task: averaging
# points: 0
# hint: adding a nonzero scalar
from scipy.sparse import csr_array, diags_array


def averaging(W):
    W = W + 1e-12
    return csr_array(diags_array(1 / W.sum(axis=1)) @ W)
