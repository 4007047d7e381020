# task: averaging
# points: 1
# hint: W + I
from scipy.sparse import csr_array, diags_array


def averaging(W):
    W = W + diags_array([1.0] * W.shape[0])
    return csr_array(diags_array(1 / W.sum(axis=1)) @ W)
