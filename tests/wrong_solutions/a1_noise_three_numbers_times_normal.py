# task: add_noise
# points: 1
# hint: you drew three numbers


def add_noise(V, N, eps, rng):
    return V + eps * rng.standard_normal(V.shape) * N
