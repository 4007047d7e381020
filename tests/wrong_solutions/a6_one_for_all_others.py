# task: held_out
# points: 0
# hint: learn from one shape and try on the others
import numpy as np


def held_out(G, N_true, shape, ridge):
    errors = []
    for s in range(shape.max() + 1):
        table = fit(G[shape == s], N_true[shape == s], ridge)
        N = filtered(G[shape != s], table)
        cosine = np.clip((N * N_true[shape != s]).sum(axis=1), -1, 1)
        errors.append(np.degrees(np.arccos(cosine)).mean())
    return np.array(errors)
