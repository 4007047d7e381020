# task: add_noise
# points: 2
# hint: does not depend on eps


def add_noise(V, N, eps, rng):
    return V + rng.normal(eps, 1, (len(V), 1)) * N
