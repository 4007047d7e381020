# task: normal_angle
# points: 1
# hint: first the angles, then their mean
import numpy as np


def normal_angle(N, N_true):
    return np.degrees(np.arccos(np.clip((N * N_true).sum(axis=1).mean(), -1, 1)))
