# task: face_normals
# points: 1
# hint: point inward
import numpy as np


def face_normals(V, F):
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    N = np.cross(c - a, b - a)
    return N / np.linalg.norm(N, axis=1, keepdims=True)
