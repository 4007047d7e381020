# task: add_noise
# points: 2
# hint: no square root
import numpy as np


def add_noise(V, N, eps, rng):
    return V + rng.normal(0, np.sqrt(eps), (len(V), 1)) * N
