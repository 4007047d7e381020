# task: denoise
# points: 0
# hint: much worse than before


def denoise(V, F):
    A = operators.averaging(weights.combinatorial(F, len(V)))
    for _ in range(400):
        V = A @ V
    return V
