# task: laplacian
# points: 0
# hint: W - D
from scipy.sparse import csr_array, diags_array


def laplacian(W):
    return csr_array(W - diags_array(W.sum(axis=1)))
