# task: laplacian
# points: 0
# hint: counts the neighbours
import numpy as np
from scipy.sparse import csr_array, diags_array


def laplacian(W):
    return csr_array(diags_array(np.diff(W.indptr).astype(float)) - W)
