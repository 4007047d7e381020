# task: averaging
# points: 0
# hint: is the `return` missing
from scipy.sparse import csr_array, diags_array


def averaging(W):
    print(csr_array(diags_array(1 / W.sum(axis=1)) @ W))
