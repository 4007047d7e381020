# task: heat
# points: 0
# hint: always that of the first state


def heat(V, A, tau, steps):
    X = V.copy()
    change = A @ V - V
    for _ in range(steps):
        X += tau * change
    return X
