# task: heat
# points: 0
# hint: exp(-t (I - A))
import numpy as np
from scipy.linalg import expm


def heat(V, A, tau, steps):
    return expm(-tau * steps * (np.eye(len(V)) - A.toarray())) @ V
