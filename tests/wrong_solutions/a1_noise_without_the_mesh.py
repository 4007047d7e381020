# task: add_noise
# points: 1
# hint: return V + noise


def add_noise(V, N, eps, rng):
    return eps * rng.standard_normal((len(V), 1)) * N
