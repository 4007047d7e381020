# task: fit
# points: 0
# hint: still to be solved


def fit(G, N_true, ridge):
    X = G.transpose(0, 2, 1).reshape(-1, G.shape[1])
    return X.T @ N_true.ravel()
