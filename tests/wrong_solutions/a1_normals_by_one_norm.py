# task: face_normals
# points: 0
# hint: by the norm of the whole array
# also: what is missing is the division; not of length one
import numpy as np


def face_normals(V, F):
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    N = np.cross(b - a, c - a)
    return N / np.linalg.norm(N)
