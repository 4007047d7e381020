# task: fit
# points: 0
# hint: its square:
import numpy as np


def fit(G, N_true, ridge):
    X = G.transpose(0, 2, 1).reshape(-1, G.shape[1])
    rows = np.concatenate([X, ridge * np.eye(X.shape[1])])
    wanted = np.concatenate([N_true.ravel(), np.zeros(X.shape[1])])
    return np.linalg.lstsq(rows, wanted, rcond=None)[0]
