"""Every metric of two meshes, or why it does not fit them."""

from collections.abc import Callable

from numpy.typing import ArrayLike

from meshfair.checks import MeshError, check_mesh
from meshfair.mesh import takes_meshes
from meshfair.metrics.matching import compact, same_orientation, same_vertices
from meshfair.metrics.measure import Measure
from meshfair.metrics.rowwise import normal_angle, snr
from meshfair.metrics.sizes import relative_area, relative_volume
from meshfair.metrics.surfaces import hausdorff, surface_distance, vertex_distance


@takes_meshes
def compare(V: ArrayLike, F: ArrayLike, V_true: ArrayLike, F_true: ArrayLike) -> dict[str, Measure]:
    """Every metric of a mesh and its ground truth, or why it does not fit them.

    Vertices that no face uses are no part of a mesh, and count in none.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The noisy or denoised mesh.
    F : array_like of integers, shape (m, 3)
    V_true : array_like, shape (n_true, 3)
    F_true : array_like of integers, shape (m_true, 3)

    Returns
    -------
    dict of str to Measure
        snr in decibels (infinite where the meshes are equal) and normal_angle in
        degrees: of meshes with the same faces, in any order, see `matched`.
        vertex_distance, surface_distance and hausdorff in mean edge lengths of the
        ground truth, the last two with a bound on their error. volume_change and
        area_change as parts of the true value; that of the volume where both
        meshes are closed.

    Raises
    ------
    MeshError
        One of the two is no mesh.
    """
    V, F = check_mesh(V, F)
    V_true, F_true = check_mesh(V_true, F_true)
    used, F = compact(F)
    used_true, F_true = compact(F_true)
    V, V_true = V[used], V_true[used_true]

    def by_vertex() -> Measure:
        return Measure(snr(V_true[same_vertices(V, F, V_true, F_true)], V))

    def by_face() -> Measure:
        rows = same_vertices(V, F, V_true, F_true)
        if not same_orientation(rows[F], F_true):
            raise MeshError(
                "some faces are turned the other way round in one of the meshes; "
                'orient both by mesh.repair(V, F, orient="outward")'
            )
        return Measure(normal_angle(V, V_true[rows], F))

    metrics: dict[str, Callable[[], Measure]] = {
        "snr": by_vertex,
        "normal_angle": by_face,
        "vertex_distance": lambda: Measure(vertex_distance(V, V_true, F_true)),
        "surface_distance": lambda: surface_distance(V, F, V_true, F_true),
        "hausdorff": lambda: hausdorff(V, F, V_true, F_true),
        "volume_change": lambda: Measure(relative_volume(V, F, V_true, F_true)),
        "area_change": lambda: Measure(relative_area(V, F, V_true, F_true)),
    }
    return {name: _or_why_not(metric) for name, metric in metrics.items()}


def _or_why_not(metric: Callable[[], Measure]) -> Measure:
    try:
        return metric()
    except MeshError as error:
        return Measure(None, reason=str(error))
