# task: denoise
# points: 0
# hint: Nothing has moved


def denoise(V, F):
    return V.copy()
