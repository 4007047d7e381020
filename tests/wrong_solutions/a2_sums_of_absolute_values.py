# task: averaging
# points: 0
# hint: by the sum of the absolute values
from scipy.sparse import csr_array, diags_array


def averaging(W):
    return csr_array(diags_array(1 / abs(W).sum(axis=1)) @ W)
