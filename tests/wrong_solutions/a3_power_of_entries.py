# task: average
# points: 0
# hint: raises each entry


def average(V, A, steps):
    return A.power(steps) @ V
