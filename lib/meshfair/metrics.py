"""How far a mesh is from the clean one: SNR, normals, surface, volume."""

import numpy as np

from meshfair.checks import MeshError, check_mesh, check_same_vertices, check_vertices
from meshfair.mesh import face_normals, mean_edge_length, volume
from meshfair.noise import snr

__all__ = ["normal_angle", "snr", "surface_distance", "volume_change"]


def normal_angle(V, V_clean, F):
    """Mean angle between the face normals of two meshes, in degrees.

    The average angular deviation of the mesh-denoising literature: the mean
    over the faces, each counted the same whatever its area.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The noisy or denoised mesh.
    V_clean : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
        The faces that both meshes have.

    Returns
    -------
    float
        Degrees, 0 to 180. A face without area has no normal: in ``V`` it counts as
        90 degrees, in ``V_clean`` there is nothing to compare with and it is left out.

    Raises
    ------
    MeshError
        Arrays that do not fit together, or a clean mesh without any area.
    """
    return float(normal_angles(V, V_clean, F).mean())


def normal_angles(V, V_clean, F):
    """The angles that `normal_angle` is the mean of, in degrees: one for each face.

    Returns
    -------
    ndarray of float64, shape (m,), or fewer where the clean mesh has faces
    without area.
    """
    V, V_clean = check_same_vertices(V, V_clean, ("V", "V_clean"))
    n, n_clean = face_normals(V, F), face_normals(V_clean, F)
    known = n_clean.any(axis=1)
    if not known.any():
        raise MeshError("V_clean has no face with an area, so no normal to compare with")
    n, n_clean = n[known], n_clean[known]
    # atan2 keeps its accuracy at small angles, where acos loses half the digits.
    sine = np.linalg.norm(np.cross(n, n_clean), axis=1)
    cosine = np.einsum("ij,ij->i", n, n_clean)
    angles = np.degrees(np.arctan2(sine, cosine))
    return np.where(n.any(axis=1), angles, 90.0)


def surface_distance(V, V_clean, F_clean):
    """Mean distance from the vertices to the clean surface, over its mean edge length.

    Does not punish a vertex that slides along the surface, as the SNR does.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    V_clean : array_like, shape (n_clean, 3)
        Need not have the vertices of ``V``.
    F_clean : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        In mean edge lengths of the clean mesh. The distances are libigl's.

    Raises
    ------
    MeshError
        No vertices, or no clean mesh.
    """
    import igl  # half a second to load, for this function alone

    V = check_vertices(V)
    V_clean, F_clean = check_mesh(V_clean, F_clean)
    squared = igl.point_mesh_squared_distance(V, V_clean, F_clean)[0]
    return float(np.sqrt(np.maximum(squared, 0)).mean() / mean_edge_length(V_clean, F_clean))


def volume_change(V, V_clean, F):
    """Relative change of the enclosed volume: -0.02 where two percent are lost.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    V_clean : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        (volume - clean volume) / |clean volume|; see `meshfair.mesh.volume`
        for what an open mesh's volume is.

    Raises
    ------
    MeshError
        Arrays that do not fit together, or a clean mesh of volume 0.
    """
    V, V_clean = check_same_vertices(V, V_clean, ("V", "V_clean"))
    clean = volume(V_clean, F)
    if clean == 0:
        raise MeshError("V_clean encloses no volume, so there is nothing to compare with")
    return (volume(V, F) - clean) / abs(clean)
