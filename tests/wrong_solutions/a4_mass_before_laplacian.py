# task: implicit_step
# points: 0
# hint: M stands in front of L
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu


def implicit_step(V, M, L, t):
    return splu(csc_array(eye_array(len(V)) + t * M @ L)).solve(V)
