# task: fit
# points: 0
# hint: mixes entries and coordinates
import numpy as np


def fit(G, N_true, ridge):
    X = G.reshape(-1, G.shape[1])
    A = X.T @ X + ridge * np.eye(X.shape[1])
    return np.linalg.solve(A, X.T @ N_true.ravel())
