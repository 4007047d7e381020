# task: mass_matrix
# points: 0
# hint: Build it sparse
import numpy as np

right = mass_matrix


def mass_matrix(V, F):
    return np.diag(right(V, F).diagonal())
