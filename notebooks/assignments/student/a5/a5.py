"""Assignment 5: keep the missiles.

Fill in the functions; the notebook a5.ipynb explains and checks them.
V: positions, shape (n, 3). F: triangles, shape (m, 3), indices of vertices.
"""

import numpy as np

from meshfair import mesh, operators, weights


def gain(V, V_noisy, V_true, part):
    """How much closer to the clean mesh a part has come, in decibels.

    V is the denoised mesh, part a boolean mask of shape (n,).

    Returns
    -------
    float
    """
    raise NotImplementedError


def denoise(V, F):
    """Clean the airframe and keep the missiles.

    Returns
    -------
    array, shape (n, 3)
    """
    raise NotImplementedError
