# task: normal_angle
# points: 2
# hint: np.clip
import numpy as np


def normal_angle(N, N_true):
    return np.degrees(np.arccos((N * N_true).sum(axis=1))).mean()
