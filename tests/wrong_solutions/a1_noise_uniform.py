# task: add_noise
# points: 2
# hint: rng.standard_normal


def add_noise(V, N, eps, rng):
    return V + eps * rng.random((len(V), 1)) * N
