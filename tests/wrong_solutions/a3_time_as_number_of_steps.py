# task: heat
# points: 2
# hint: Only one step was made


def heat(V, A, tau, steps):
    for _ in range(int(steps * tau)):
        V = (1 - tau) * V + tau * (A @ V)
    return V
