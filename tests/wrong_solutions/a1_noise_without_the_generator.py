# task: add_noise
# points: 3
# hint: draw with rng
import numpy as np


def add_noise(V, N, eps, rng):
    return V + eps * np.random.default_rng().standard_normal((len(V), 1)) * N
