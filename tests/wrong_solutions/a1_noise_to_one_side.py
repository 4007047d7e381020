# task: add_noise
# points: 2
# hint: move to the same side
import numpy as np


def add_noise(V, N, eps, rng):
    return V + eps * np.abs(rng.standard_normal((len(V), 1))) * N
