# task: best_stopping
# points: 0
# hint: in this order: return time, snr


right_stopping = best_stopping


def best_stopping(V_noisy, V_true, A, tau, steps):
    return right_stopping(V_noisy, V_true, A, tau, steps)[::-1]
