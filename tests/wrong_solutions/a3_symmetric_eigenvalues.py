# task: largest_stable_step
# points: 0
# hint: takes it for symmetric
import numpy as np


def largest_stable_step(A):
    return 2 / np.linalg.eigvalsh(np.eye(A.shape[0]) - A.toarray()).max()
