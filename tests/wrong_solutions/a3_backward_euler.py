# task: heat
# points: 0
# hint: backward Euler
import numpy as np


def heat(V, A, tau, steps):
    system = (1 + tau) * np.eye(len(V)) - tau * A.toarray()
    for _ in range(steps):
        V = np.linalg.solve(system, V)
    return V
