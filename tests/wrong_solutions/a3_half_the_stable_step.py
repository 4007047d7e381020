# task: largest_stable_step
# points: 0
# hint: 1 / mu_max
import numpy as np


def largest_stable_step(A):
    return 1 / np.linalg.eigvals(np.eye(A.shape[0]) - A.toarray()).real.max()
