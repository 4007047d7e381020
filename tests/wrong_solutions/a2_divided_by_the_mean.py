# task: averaging
# points: 0
# hint: by the mean of each row
from scipy.sparse import csr_array, diags_array


def averaging(W):
    return csr_array(diags_array(1 / W.mean(axis=1)) @ W)
