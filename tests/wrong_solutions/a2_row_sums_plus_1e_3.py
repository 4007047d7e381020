# task: averaging
# points: 0
# hint: divide by d_i itself
from scipy.sparse import csr_array, diags_array


def averaging(W):
    return csr_array(diags_array(1 / (W.sum(axis=1) + 1e-3)) @ W)
