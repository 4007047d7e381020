# task: edges
# points: 0
# hint: sets have no order


def edges(F):
    return list({frozenset((f[i], f[i - 1])) for f in F for i in range(3)})
