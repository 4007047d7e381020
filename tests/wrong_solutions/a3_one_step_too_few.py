# task: average
# points: 0
# hint: One step too few


def average(V, A, steps):
    for _ in range(1, steps):
        V = A @ V
    return V
