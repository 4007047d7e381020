# task: add_noise
# points: 3
# hint: not with np.random
import numpy as np


def add_noise(V, N, eps, rng):
    return V + eps * np.random.default_rng().standard_normal((len(V), 1)) * N
