# task: add_noise
# points: 2
# hint: move by the same amount


def add_noise(V, N, eps, rng):
    return V + eps * rng.standard_normal() * N
