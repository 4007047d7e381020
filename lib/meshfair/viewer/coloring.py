"""What a mesh can be coloured by: names, units, and the package's functions.

Each quantity is a function of the ground truth that returns a function of
positions: what depends on the ground truth alone is computed once.

References
----------
.. [PP93] U. Pinkall, K. Polthier, Computing discrete minimal surfaces and their
   conjugates, Experimental Mathematics 2(1), 1993.
.. [MD99] M. Desbrun, M. Meyer, P. Schroeder, A. H. Barr, Implicit fairing of
   irregular meshes using diffusion and curvature flow, SIGGRAPH 1999.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from meshfair.checks import Floats, Integers
from meshfair.mesh import face_normals, mean_edge_length, vertex_normals
from meshfair.metrics import normal_angles
from meshfair.operators import diffusion, mass
from meshfair.weights import cotangent

Quantity = Callable[[Floats], Floats]


def displacement(V_true: Floats, F: Integers) -> Quantity:
    """Distance of each vertex from its true place, in mean edge lengths; shape (n,)."""
    unit = mean_edge_length(V_true, F)
    return lambda V: np.linalg.norm(V - V_true, axis=1) / unit


def signed_displacement(V_true: Floats, F: Integers) -> Quantity:
    """Displacement of each vertex along its true normal, in mean edge lengths; shape (n,).

    Above 0 outwards, below 0 inwards: where a mesh has shrunk, it is negative all over.
    """
    unit, normals = mean_edge_length(V_true, F), vertex_normals(V_true, F)
    return lambda V: np.sum((V - V_true) * normals, axis=1) / unit


def normal_angle(V_true: Floats, F: Integers) -> Quantity:
    """Angle between each face's normal and its true one, in degrees; shape (m,).

    0 for a face without area in the ground truth, which has no normal.
    """
    known = face_normals(V_true, F).any(axis=1)

    def values(V: Floats) -> Floats:
        angles = np.zeros(len(F))
        angles[known] = normal_angles(V, V_true, F)
        return angles

    return values


def curvature(V_true: Floats, F: Integers) -> Quantity:
    """Size of the mean curvature at each vertex, times the mean edge length; shape (n,).

    Half of |M^-1 L V|, the cotangent formula of [PP93]_ and [MD99]_; 0.1 on a
    sphere whose radius is ten edges. The ground truth sets the unit of length.
    """
    unit = mean_edge_length(V_true, F)

    def values(V: Floats) -> Floats:
        A = diffusion(cotangent(V, F), mass(V, F))
        return np.linalg.norm(V - A @ V, axis=1) / 2 * unit

    return values


class Coloring(NamedTuple):
    """A quantity to colour meshes by."""

    label: str
    """What it is, with its unit: the colour bar's label."""
    of: Callable[[Floats, Integers], Quantity]
    """function(V_true, F) -> function(V) -> one number for each vertex or each face."""
    least: float
    """The smallest end of a colour bar that still shows something, and not rounding errors."""
    signed: bool = False
    """Whether 0 is in the middle of the colour bar, and not at its low end."""

    @property
    def cmap(self) -> str:
        """Its colour map, one of `meshfair.viewer.CMAPS`."""
        return "coolwarm" if self.signed else "viridis"

    def limits(self, *values: Floats) -> tuple[float, float]:
        """Round ends of a colour bar for some meshes' values: 2 % of them may lie beyond.

        From 0 to the 98th percentile of that mesh in which it is largest, or, with a sign,
        as far on both sides of 0; so that a few extreme values do not hide the rest.
        """
        high = round_up(max(self.least, *(limits(np.abs(x))[1] for x in values)))
        return (-high if self.signed else 0.0), high


COLORINGS = {
    "displacement": Coloring("displacement (mean edges)", displacement, 0.05),
    "signed displacement": Coloring(
        "displacement outwards (mean edges)",
        signed_displacement,
        0.05,
        signed=True,
    ),
    "normal angle": Coloring("normal angle (degrees)", normal_angle, 1.0),
    "curvature": Coloring("mean curvature (1 / mean edge)", curvature, 0.01),
}


def limits(values: Floats) -> tuple[float, float]:
    """Ends of a colour bar on which a few extreme values do not hide the rest."""
    return 0.0, float(np.percentile(values, 98))


ROUND = (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10)


def round_up(number: float) -> float:
    """The next number, from this one upwards, that a colour bar can end at: 0.3, 1.2, 50."""
    power = 10.0 ** np.floor(np.log10(number))
    digits = next(digit for digit in ROUND if digit * power >= number * (1 - 1e-12))
    return float(digits * power)
