# task: normal_angle
# points: 1
# hint: radians
import numpy as np


def normal_angle(N, N_true):
    return np.arccos(np.clip((N * N_true).sum(axis=1), -1, 1)).mean()
