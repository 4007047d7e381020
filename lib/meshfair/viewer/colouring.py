"""What a mesh can be coloured by: names, units, and the package's functions.

Each quantity is a function of the clean mesh that returns a function of
positions: what depends on the clean mesh alone is computed once.
"""

from typing import NamedTuple

import numpy as np

from meshfair.mesh import face_normals, mean_edge_length
from meshfair.metrics import normal_angles
from meshfair.operators import diffusion, mass
from meshfair.weights import cotangent


def displacement(V_true, F):
    """Distance of each vertex from its clean place, in mean edge lengths; shape (n,)."""
    unit = mean_edge_length(V_true, F)
    return lambda V: np.linalg.norm(V - V_true, axis=1) / unit


def normal_angle(V_true, F):
    """Angle between each face's normal and its clean one, in degrees; shape (m,).

    0 for a face without area in the clean mesh, which has no normal.
    """
    known = face_normals(V_true, F).any(axis=1)

    def values(V):
        angles = np.zeros(len(F))
        angles[known] = normal_angles(V, V_true, F)
        return angles

    return values


def curvature(V_true, F):
    """Size of the mean curvature at each vertex, times the mean edge length; shape (n,).

    Half of |M^-1 L V|, the cotangent formula of [PP93, MD99]; 0.1 on a sphere
    whose radius is ten edges. The clean mesh sets the unit of length.
    """
    unit = mean_edge_length(V_true, F)

    def values(V):
        A = diffusion(cotangent(V, F), mass(V, F))
        return np.linalg.norm(V - A @ V, axis=1) / 2 * unit

    return values


class Colouring(NamedTuple):
    """A quantity to colour meshes by."""

    label: str
    """What it is, with its unit: the colour bar's label."""
    of: object
    """function(V_true, F) -> function(V) -> one number for each vertex or each face."""


COLOURINGS = {
    "displacement": Colouring("displacement (mean edges)", displacement),
    "normal angle": Colouring("normal angle (degrees)", normal_angle),
    "curvature": Colouring("mean curvature (1 / mean edge)", curvature),
}


def limits(values):
    """Ends of a colour bar on which a few extreme values do not hide the rest."""
    return 0.0, float(np.percentile(values, 98))
