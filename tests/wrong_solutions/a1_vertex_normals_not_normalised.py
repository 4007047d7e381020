# task: vertex_normals
# points: 0
# hint: not of length one
import numpy as np


def vertex_normals(V, F):
    N = np.zeros(V.shape)
    count = np.zeros(len(V))
    for f, n in zip(F, face_normals(V, F)):
        N[f] += n
        count[f] += 1
    return N / count[:, None]
