# task: largest_stable_step
# points: 0
# hint: 2 / the largest eigenvalue of A
import numpy as np


def largest_stable_step(A):
    return 2 / np.abs(np.linalg.eigvals(A.toarray())).max()
