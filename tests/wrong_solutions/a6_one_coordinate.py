# task: fit
# points: 0
# hint: one coordinate of three
import numpy as np


def fit(G, N_true, ridge):
    X = G[:, :, 0]
    A = X.T @ X + ridge * np.eye(X.shape[1])
    return np.linalg.solve(A, X.T @ N_true[:, 0])
