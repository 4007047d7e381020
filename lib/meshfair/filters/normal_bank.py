"""A bank of filtered normals: what the learned filter compares, and chooses from.

References
----------
.. [Wang16] P.-S. Wang, Y. Liu, X. Tong, "Mesh denoising via cascaded normal regression",
   ACM Transactions on Graphics 35(6), 2016.
"""

from collections.abc import Iterator

from meshfair.checks import Floats, Integers
from meshfair.filters.diffusion import taubin
from meshfair.filters.guided_normal import Patches, guidance
from meshfair.filters.normal_filtering import joint_bilateral, mean_distance, spatial_weights
from meshfair.mesh import face_shapes

# sigma_s of the bilateral filters: on one surface, across a soft crease, across any.
NARROW, WIDE, ANY = 0.3, 0.5, 1e3
# Steps of Taubin's filter after which the smoothed surface gives its normals.
SURFACES = (3, 10, 30)
COUNT = 14


def surfaces(V: Floats, F: Integers) -> list[Floats]:
    """Positions after 3, 10 and 30 steps of Taubin's filter.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    list of ndarray of float64, each of shape (n, 3)
    """
    states = enumerate(taubin(V, F, iterations=SURFACES[-1]), start=1)
    return [X for step, (_, X) in states if step in SURFACES]


def filtered_normals(
    V: Floats, F: Integers, smoothed: list[Floats], patches: Patches
) -> Iterator[Floats]:
    """Normals of each face, filtered in 14 ways one after the other [Wang16]_.

    In this order: those of the surfaces smoothed by Taubin's filter; bilateral ones that
    begin with the first of these; the mesh's own; means over 1 and over 3 rings; bilateral
    ones, narrow and wide, after 4 and 16 iterations each; guidance normals; guided ones
    after 4 and 12 iterations.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    smoothed : list of ndarray of float64, each of shape (n, 3)
        See `surfaces`.
    patches : Patches
        See `meshfair.filters.guided_normal.Patches`.

    Yields
    ------
    ndarray of float64, shape (m, 3)
        Unit vectors; zero for a face without area, until those around give it a normal.
    """
    N, area, C = face_shapes(V, F)
    S = spatial_weights(patches.rings, C, area, mean_distance(C, patches.adjacent))

    def bilateral(X: Floats, sigma: float, stops: tuple[int, ...]) -> Iterator[Floats]:
        for iteration in range(1, stops[-1] + 1):
            X = joint_bilateral(S, X, X, sigma)
            if iteration in stops:
                yield X

    of_surfaces = [face_shapes(X, F)[0] for X in smoothed]
    yield from of_surfaces
    yield from bilateral(of_surfaces[0], NARROW, (8,))
    yield N
    yield from bilateral(N, ANY, (1, 3))
    yield from bilateral(N, NARROW, (4, 16))
    yield from bilateral(N, WIDE, (4, 16))
    yield guidance(patches, N, area)
    for iteration in range(1, 13):
        N = joint_bilateral(S, N, guidance(patches, N, area), NARROW)
        if iteration in (4, 12):
            yield N
