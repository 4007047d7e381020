# task: add_noise
# points: 2
# hint: multiplied by eps twice


def add_noise(V, N, eps, rng):
    return V + eps * rng.normal(0, eps, (len(V), 1)) * N
