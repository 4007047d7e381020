# task: averaging
# points: 0
# hint: number of neighbours
import numpy as np
from scipy.sparse import csr_array, diags_array


def averaging(W):
    return csr_array(diags_array(1 / np.diff(W.indptr)) @ W)
