"""How far a mesh is from the ground truth: SNR, normals, surface, volume, area."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import (
    Floats,
    Integers,
    MeshError,
    check_mesh,
    check_same_vertices,
    check_vertices,
)
from meshfair.mesh import area, face_normals, mean_edge_length, volume

__all__ = [
    "area_change",
    "compare",
    "hausdorff",
    "normal_angle",
    "normal_angles",
    "snr",
    "surface_distance",
    "volume_change",
]


def snr(V: ArrayLike, V_noisy: ArrayLike) -> float:
    """Signal-to-noise ratio of a noisy mesh, in decibels (the original report, Def. 1).

    SNR = -20 log10( sum_i |v_i - v~_i| / sum_i |v_i| ). The denominator
    depends on where the origin lies: moving both meshes together changes the
    ratio.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The ground truth.
    V_noisy : array_like, shape (n, 3)
        The noisy or the denoised one, vertices in the same order.

    Returns
    -------
    float
        Decibels; infinite where both meshes are equal.

    Raises
    ------
    MeshError
        No vertices, different numbers of them, or a ground truth that has all
        its vertices at the origin.
    """
    V, V_noisy = check_same_vertices(V, V_noisy, ("V", "V_noisy"))
    return float(snr_of_distances(V, np.linalg.norm(V - V_noisy, axis=1).sum()))


def snr_of_distances(V: Floats, distances: ArrayLike) -> Floats:
    """SNR = -20 log10(distances / sum_i |v_i|), where the sums of the distances are known.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
        The ground truth.
    distances : array_like
        sum_i |v_i - v~_i|, of one mesh or of several, in the units of ``V``.

    Returns
    -------
    ndarray of float64, of the shape of ``distances``
        Decibels; infinite where the distances are 0.

    Raises
    ------
    MeshError
        All vertices of V are at the origin.
    """
    signal = np.linalg.norm(V, axis=1).sum()
    if signal == 0:
        raise MeshError("V has all its vertices at the origin, so it has no SNR; move it")
    with np.errstate(divide="ignore"):  # no distance at all is an infinite SNR
        return -20 * np.log10(np.asarray(distances) / signal)


def normal_angle(V: ArrayLike, V_true: ArrayLike, F: ArrayLike) -> float:
    """Mean angle between the face normals of two meshes, in degrees.

    The average angular deviation of the mesh-denoising literature: the mean
    over the faces, each counted the same whatever its area.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The noisy or denoised mesh.
    V_true : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
        The faces that both meshes have.

    Returns
    -------
    float
        Degrees, 0 to 180. A face without area has no normal: in ``V`` it counts as
        90 degrees, in ``V_true`` there is nothing to compare with and it is left out.

    Raises
    ------
    MeshError
        Arrays that do not fit together, or a ground truth without any area.
    """
    return float(normal_angles(V, V_true, F).mean())


def normal_angles(V: ArrayLike, V_true: ArrayLike, F: ArrayLike) -> Floats:
    """The angles that `normal_angle` is the mean of, in degrees: one for each face.

    Returns
    -------
    ndarray of float64, shape (m,), or fewer where the ground truth has faces
    without area.
    """
    V, V_true = check_same_vertices(V, V_true, ("V", "V_true"))
    n, n_true = face_normals(V, F), face_normals(V_true, F)
    known = n_true.any(axis=1)
    if not known.any():
        raise MeshError("V_true has no face with an area, so no normal to compare with")
    n, n_true = n[known], n_true[known]
    # atan2 keeps its accuracy at small angles, where acos loses half the digits.
    sine = np.linalg.norm(np.cross(n, n_true), axis=1)
    cosine = np.einsum("ij,ij->i", n, n_true)
    angles = np.degrees(np.arctan2(sine, cosine))
    return np.where(n.any(axis=1), angles, 90.0)


def surface_distance(V: ArrayLike, V_true: ArrayLike, F_true: ArrayLike) -> float:
    """Mean distance from the vertices to the true surface, over its mean edge length.

    Does not punish a vertex that slides along the surface, as the SNR does.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    V_true : array_like, shape (n_true, 3)
        Need not have the vertices of ``V``.
    F_true : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        In mean edge lengths of the ground truth. The distances are libigl's.

    Raises
    ------
    MeshError
        No vertices, or no ground truth.
    """
    import igl  # half a second to load, for two functions alone

    V = check_vertices(V)
    V_true, F_true = check_mesh(V_true, F_true)
    squared = igl.point_mesh_squared_distance(V, V_true, F_true)[0]
    return float(np.sqrt(np.maximum(squared, 0)).mean() / _unit(V_true, F_true))


def hausdorff(V: ArrayLike, F: ArrayLike, V_true: ArrayLike, F_true: ArrayLike) -> float:
    """Hausdorff distance between two surfaces, over the ground truth's mean edge length.

    The largest distance from a vertex of either mesh to the surface of the
    other. Vertices without faces are no part of a surface and are left out.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    V_true : array_like, shape (n_true, 3)
    F_true : array_like of integers, shape (m_true, 3)

    Returns
    -------
    float
        In mean edge lengths of the ground truth. The distance is libigl's.

    Raises
    ------
    MeshError
        One of the two is no mesh.
    """
    import igl  # half a second to load, for two functions alone

    V, F = check_mesh(V, F)
    V_true, F_true = check_mesh(V_true, F_true)
    distance = igl.hausdorff(*_referenced(V, F), *_referenced(V_true, F_true))
    return distance / _unit(V_true, F_true)


def _unit(V_true: Floats, F_true: Integers) -> float:
    length = mean_edge_length(V_true, F_true)
    if length == 0:
        raise MeshError("V_true has all its vertices in one place, so no edge length as a unit")
    return length


def _referenced(V: Floats, F: Integers) -> tuple[Floats, Integers]:
    """The mesh without the vertices that no face uses."""
    used, corners = np.unique(F, return_inverse=True)
    return V[used], corners.reshape(F.shape)


def volume_change(V: ArrayLike, V_true: ArrayLike, F: ArrayLike) -> float:
    """Relative change of the enclosed volume: -0.02 where two percent are lost.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    V_true : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        (volume - true volume) / |true volume|; see `meshfair.mesh.volume`
        for what an open mesh's volume is.

    Raises
    ------
    MeshError
        Arrays that do not fit together, or a ground truth of volume 0.
    """
    V, V_true = check_same_vertices(V, V_true, ("V", "V_true"))
    return _change(volume(V, F), volume(V_true, F), "V_true encloses no volume")


def area_change(V: ArrayLike, V_true: ArrayLike, F: ArrayLike) -> float:
    """Relative change of the surface's area: 0.3 where noise has added thirty percent.

    Parameters and errors are those of `volume_change`.

    Returns
    -------
    float
        (area - true area) / true area.
    """
    V, V_true = check_same_vertices(V, V_true, ("V", "V_true"))
    return _change(area(V, F), area(V_true, F), "V_true has no area")


def _change(value: float, true: float, nothing: str) -> float:
    if true == 0:
        raise MeshError(f"{nothing}, so there is nothing to compare with")
    return (value - true) / abs(true)


def compare(
    V: ArrayLike, F: ArrayLike, V_true: ArrayLike, F_true: ArrayLike
) -> dict[str, float | None]:
    """Every metric that fits the two meshes.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The noisy or denoised mesh.
    F : array_like of integers, shape (m, 3)
    V_true : array_like, shape (n_true, 3)
    F_true : array_like of integers, shape (m_true, 3)

    Returns
    -------
    dict of str to float or None
        snr in decibels, normal_angle in degrees, surface_distance and
        hausdorff in mean edge lengths of the ground truth, volume_change and
        area_change as parts of the true value. SNR and normal angle compare
        vertex by vertex and face by face: they are None unless both meshes
        have the same faces and number of vertices. None also stands where the
        ground truth has nothing to compare with (no extent, volume or area).

    Raises
    ------
    MeshError
        One of the two is no mesh.
    """
    V, F = check_mesh(V, F)
    V_true, F_true = check_mesh(V_true, F_true)
    same = len(V) == len(V_true) and np.array_equal(F, F_true)
    metrics = {
        "snr": lambda: snr(V_true, V) if same else None,
        "normal_angle": lambda: normal_angle(V, V_true, F) if same else None,
        "surface_distance": lambda: surface_distance(V, V_true, F_true),
        "hausdorff": lambda: hausdorff(V, F, V_true, F_true),
        "volume_change": lambda: _change(volume(V, F), volume(V_true, F_true), "no volume"),
        "area_change": lambda: _change(area(V, F), area(V_true, F_true), "no area"),
    }
    return {name: _or_none(metric) for name, metric in metrics.items()}


def _or_none(metric: Callable[[], float | None]) -> float | None:
    try:
        return metric()
    except MeshError:  # the ground truth has nothing to compare with
        return None
