# task: fit
# points: 0
# hint: ridge is missing
import numpy as np


def fit(G, N_true, ridge):
    X = G.transpose(0, 2, 1).reshape(-1, G.shape[1])
    return np.linalg.lstsq(X, N_true.ravel(), rcond=None)[0]
