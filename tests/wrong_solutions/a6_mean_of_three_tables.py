# task: fit
# points: 0
# hint: mean of three tables
import numpy as np


def fit(G, N_true, ridge):
    tables = []
    for axis in range(3):
        X = G[:, :, axis]
        A = X.T @ X + ridge * np.eye(X.shape[1])
        tables.append(np.linalg.solve(A, X.T @ N_true[:, axis]))
    return np.mean(tables, axis=0)
