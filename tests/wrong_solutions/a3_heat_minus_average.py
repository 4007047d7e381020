# task: heat
# points: 0
# hint: what is subtracted is


def heat(V, A, tau, steps):
    for _ in range(steps):
        V = V - tau * (A @ V)
    return V
