# task: best_stopping
# points: 0
# hint: Two numbers are wanted


right = best_stopping


def best_stopping(V_noisy, V_true, A, tau, steps):
    t, s = right(V_noisy, V_true, A, tau, steps)
    return t
