# task: averaging
# points: 0
# hint: did you add both halves of an edge
from scipy.sparse import csr_array, diags_array


def averaging(W):
    return csr_array(diags_array(2 / W.sum(axis=1)) @ W)
