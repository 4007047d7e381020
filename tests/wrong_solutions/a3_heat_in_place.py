# task: heat
# points: 2.5
# hint: work on a copy


def heat(V, A, tau, steps):
    for _ in range(steps):
        V += tau * (A @ V - V)
    return V
