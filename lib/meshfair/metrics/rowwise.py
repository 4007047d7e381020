"""Vertex by vertex and face by face: SNR, and the angle between normals."""

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Floats, MeshError, check_same_vertices
from meshfair.mesh import face_normals, takes_meshes


@takes_meshes
def snr(V: ArrayLike, V_noisy: ArrayLike) -> float:
    """Signal-to-noise ratio of a noisy mesh, in decibels (the original report, Def. 1).

    SNR = -20 log10( sum_i |v_i - v~_i| / sum_i |v_i| ). The denominator
    depends on where the origin lies: the farther the meshes are from it, the
    higher the ratio, so compare SNRs of meshes in one place only.

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


@takes_meshes
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


@takes_meshes
def normal_angles(V: ArrayLike, V_true: ArrayLike, F: ArrayLike) -> Floats:
    """The angles that `normal_angle` is the mean of, in degrees: one for each face.

    Parameters
    ----------
    V, V_true, F
        As in `normal_angle`.

    Returns
    -------
    ndarray of float64, shape (m,), or fewer where the ground truth has faces
    without area.

    Raises
    ------
    MeshError
        As `normal_angle`.
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
