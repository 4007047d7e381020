# task: heat
# points: 0
# hint: one step of size tau * steps


def heat(V, A, tau, steps):
    t = tau * steps
    return (1 - t) * V + t * (A @ V)
