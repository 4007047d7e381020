"""Assignment 1: noise, normals and the signal-to-noise ratio.

Fill in the functions; the notebook a1.ipynb explains and checks them.
V: positions, shape (n, 3). F: triangles, shape (m, 3), indices of vertices.
"""

import numpy as np


def face_normals(V, F):
    """Unit normals of the triangles, outward.

    Returns
    -------
    array, shape (m, 3)
    """
    raise NotImplementedError


def vertex_normals(V, F):
    """Unit normals of the vertices: the mean of the faces' around, weighted by area.

    Returns
    -------
    array, shape (n, 3)
    """
    raise NotImplementedError


def mean_edge_length(V, F):
    """Mean length of the edges, each counted once.

    Returns
    -------
    float
    """
    raise NotImplementedError


def add_noise(V, N, eps, rng):
    """White noise of standard deviation eps along the unit normals N.

    Returns
    -------
    array, shape (n, 3)
    """
    raise NotImplementedError


def snr(V, V_noisy):
    """Signal-to-noise ratio in decibels, V being the clean mesh.

    Returns
    -------
    float
    """
    raise NotImplementedError


def normal_angle(N, N_true):
    """Mean angle between two arrays of unit normals, in degrees.

    Returns
    -------
    float
    """
    raise NotImplementedError
