# task: largest_stable_step
# points: 0
# hint: Gershgorin


def largest_stable_step(A):
    rows = abs(A).sum(axis=1)
    return 2 / (1 + rows.max())
