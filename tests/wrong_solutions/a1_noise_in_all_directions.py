# task: add_noise
# points: 3
# hint: you drew three numbers


def add_noise(V, N, eps, rng):
    return V + eps * rng.standard_normal(V.shape)
