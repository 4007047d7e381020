# task: heat
# points: 0
# hint: runs backwards


def heat(V, A, tau, steps):
    for _ in range(steps):
        V = V + tau * (V - A @ V)
    return V
