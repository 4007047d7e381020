# task: vertex_normals
# points: 1
# hint: normal of its last triangle
import numpy as np


def vertex_normals(V, F):
    N = np.zeros(V.shape)
    N[F.ravel()] = np.repeat(face_normals(V, F), 3, axis=0)
    return N
