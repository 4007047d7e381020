# task: averaging
# points: 0
# hint: division by the row sums is missing
from scipy.sparse import csr_array


def averaging(W):
    return csr_array(W)
