# task: averaging
# points: 0
# hint: Build it sparse


def averaging(W):
    W = W.toarray()
    return W / W.sum(axis=1)[:, None]
