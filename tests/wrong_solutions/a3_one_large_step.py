# task: heat
# points: 0
# hint: all start from the first state


def heat(V, A, tau, steps):
    t = tau * steps
    return (1 - t) * V + t * (A @ V)
