# task: normal_angle
# points: 1
# hint: This is the median
import numpy as np


def normal_angle(N, N_true):
    return np.median(np.degrees(np.arccos(np.clip((N * N_true).sum(axis=1), -1, 1))))
