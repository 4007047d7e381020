# task: largest_stable_step
# points: 0
# hint: This is close to 2 / 0
import numpy as np


def largest_stable_step(A):
    mu = np.linalg.eigvals(A.toarray()).real
    return 2 / (1 - mu.max() + 1e-9)
