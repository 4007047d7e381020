# task: average
# points: 0
# hint: A transposed


def average(V, A, steps):
    for _ in range(steps):
        V = (V.T @ A).T
    return V
