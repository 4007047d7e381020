# task: normal_angle
# points: 1
# hint: This is 1 - cosine
import numpy as np


def normal_angle(N, N_true):
    return np.degrees(1 - (N * N_true).sum(axis=1)).mean()
