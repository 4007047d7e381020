# task: denoise
# points: 0
# hint: flown away


def denoise(V, F):
    A = operators.averaging(weights.combinatorial(F, len(V)))
    for _ in range(150):
        V = V - 30 * (A @ V - V)
    return V
