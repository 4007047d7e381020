"""Assignment 3: averaging, heat, and when to stop.

Fill in the functions; the notebook a3.ipynb explains and checks them.
V: positions, shape (n, 3). W, A, L: sparse matrices, shape (n, n).
"""

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array


def laplacian(W):
    """The Laplacian D - W.

    Returns
    -------
    csr_array, shape (n, n)
    """
    raise NotImplementedError


def average(V, A, steps):
    """Positions after so many steps of averaging, A^steps V.

    Returns
    -------
    array, shape (n, 3)
    """
    raise NotImplementedError


def heat(V, A, tau, steps):
    """Positions after so many steps of forward Euler for the heat equation.

    Returns
    -------
    array, shape (n, 3)
    """
    raise NotImplementedError


def largest_stable_step(A):
    """The largest tau for which forward Euler stays bounded, 2 / mu_max.

    Returns
    -------
    float
    """
    raise NotImplementedError


def best_stopping(V_noisy, V_true, A, tau, steps):
    """When the heat flow is closest to the clean mesh.

    Returns
    -------
    time : float
        A multiple of tau from 0 to tau * steps.
    snr : float
        The signal-to-noise ratio at that time, in decibels.
    """

    raise NotImplementedError
