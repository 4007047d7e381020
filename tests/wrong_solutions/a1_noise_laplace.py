# task: add_noise
# points: 2
# hint: the shape is not
import numpy as np


def add_noise(V, N, eps, rng):
    return V + rng.laplace(0, eps / np.sqrt(2), (len(V), 1)) * N
