# task: denoise
# points: 8
# hint: For all points of this part
from meshfair import operators, weights


def denoise(V, F):
    A = operators.averaging(weights.combinatorial(F, len(V)))
    return 0.8 * V + 0.2 * (A @ V)
