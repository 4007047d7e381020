# task: held_out
# points: 0
# hint: learned from all shapes
import numpy as np


def held_out(G, N_true, shape, ridge):
    errors = []
    for s in range(shape.max() + 1):
        table = fit(G, N_true, ridge)
        N = filtered(G[shape == s], table)
        cosine = np.clip((N * N_true[shape == s]).sum(axis=1), -1, 1)
        errors.append(np.degrees(np.arccos(cosine)).mean())
    return np.array(errors)
