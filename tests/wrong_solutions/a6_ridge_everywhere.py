# task: fit
# points: 0
# hint: all entries of the matrix
import numpy as np


def fit(G, N_true, ridge):
    X = G.transpose(0, 2, 1).reshape(-1, G.shape[1])
    return np.linalg.solve(X.T @ X + ridge, X.T @ N_true.ravel())
