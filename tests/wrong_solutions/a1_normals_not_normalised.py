# task: face_normals
# points: 0
# hint: what is missing is the division
# also: not of length one
import numpy as np


def face_normals(V, F):
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    return np.cross(b - a, c - a)
