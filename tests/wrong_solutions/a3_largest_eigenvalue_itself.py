# task: largest_stable_step
# points: 0
# hint: This is mu_max itself
import numpy as np


def largest_stable_step(A):
    return np.linalg.eigvals(np.eye(A.shape[0]) - A.toarray()).real.max()
