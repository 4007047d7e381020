# task: average
# points: 0
# hint: one after the other


def average(V, A, steps):
    V, A = V.copy(), A.toarray()
    for _ in range(steps):
        for i in range(len(V)):
            V[i] = A[i] @ V
    return V
