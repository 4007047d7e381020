# task: laplacian
# points: 0
# hint: I - W~
from scipy.sparse import csr_array, diags_array, eye_array


def laplacian(W):
    return csr_array(eye_array(W.shape[0]) - diags_array(1 / W.sum(axis=1)) @ W)
