# task: add_noise
# points: 2
# hint: work on a copy


def add_noise(V, N, eps, rng):
    V += eps * rng.standard_normal((len(V), 1)) * N
    return V
