# task: heat
# points: 0
# hint: The part 1 - tau is missing


def heat(V, A, tau, steps):
    for _ in range(steps):
        V = V + tau * A @ V
    return V
