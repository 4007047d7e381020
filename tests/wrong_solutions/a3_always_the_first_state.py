# task: heat
# points: 0
# hint: all start from the first state


def heat(V, A, tau, steps):
    X = V.copy()
    change = A @ V - V
    for _ in range(steps):
        X += tau * change
    return X
