# task: average
# points: 0
# hint: half steps


def average(V, A, steps):
    for _ in range(steps):
        V = (V + A @ V) / 2
    return V
