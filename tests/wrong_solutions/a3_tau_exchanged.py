# task: heat
# points: 0
# hint: exchanged


def heat(V, A, tau, steps):
    for _ in range(steps):
        V = tau * V + (1 - tau) * (A @ V)
    return V
