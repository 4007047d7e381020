"""How far a mesh is from the clean one: SNR, normals, surface, volume, area."""

import numpy as np

from meshfair.checks import MeshError, check_mesh, check_same_vertices, check_vertices
from meshfair.mesh import area, face_normals, mean_edge_length, volume
from meshfair.noise import snr

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
    import igl  # half a second to load, for two functions alone

    V = check_vertices(V)
    V_clean, F_clean = check_mesh(V_clean, F_clean)
    squared = igl.point_mesh_squared_distance(V, V_clean, F_clean)[0]
    return float(np.sqrt(np.maximum(squared, 0)).mean() / _unit(V_clean, F_clean))


def hausdorff(V, F, V_clean, F_clean):
    """Hausdorff distance between two surfaces, over the clean one's mean edge length.

    The largest distance from a vertex of either mesh to the surface of the
    other. Vertices without faces are no part of a surface and are left out.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    V_clean : array_like, shape (n_clean, 3)
    F_clean : array_like of integers, shape (m_clean, 3)

    Returns
    -------
    float
        In mean edge lengths of the clean mesh. The distance is libigl's.

    Raises
    ------
    MeshError
        One of the two is no mesh.
    """
    import igl  # half a second to load, for two functions alone

    V, F = check_mesh(V, F)
    V_clean, F_clean = check_mesh(V_clean, F_clean)
    distance = igl.hausdorff(*_referenced(V, F), *_referenced(V_clean, F_clean))
    return distance / _unit(V_clean, F_clean)


def _unit(V_clean, F_clean):
    length = mean_edge_length(V_clean, F_clean)
    if length == 0:
        raise MeshError("V_clean has all its vertices in one place, so no edge length as a unit")
    return length


def _referenced(V, F):
    """The mesh without the vertices that no face uses."""
    used, corners = np.unique(F, return_inverse=True)
    return V[used], corners.reshape(F.shape)


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
    return _change(volume(V, F), volume(V_clean, F), "V_clean encloses no volume")


def area_change(V, V_clean, F):
    """Relative change of the surface's area: 0.3 where noise has added thirty percent.

    Parameters and errors are those of `volume_change`.

    Returns
    -------
    float
        (area - clean area) / clean area.
    """
    V, V_clean = check_same_vertices(V, V_clean, ("V", "V_clean"))
    return _change(area(V, F), area(V_clean, F), "V_clean has no area")


def _change(value, clean, nothing):
    if clean == 0:
        raise MeshError(f"{nothing}, so there is nothing to compare with")
    return (value - clean) / abs(clean)


def compare(V, F, V_clean, F_clean):
    """Every metric that fits the two meshes.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The noisy or denoised mesh.
    F : array_like of integers, shape (m, 3)
    V_clean : array_like, shape (n_clean, 3)
    F_clean : array_like of integers, shape (m_clean, 3)

    Returns
    -------
    dict of str to float or None
        snr in decibels, normal_angle in degrees, surface_distance and
        hausdorff in mean edge lengths of the clean mesh, volume_change and
        area_change as parts of the clean value. SNR and normal angle compare
        vertex by vertex and face by face: they are None unless both meshes
        have the same faces and number of vertices. None also stands where the
        clean mesh has nothing to compare with (no extent, volume or area).

    Raises
    ------
    MeshError
        One of the two is no mesh.
    """
    V, F = check_mesh(V, F)
    V_clean, F_clean = check_mesh(V_clean, F_clean)
    same = len(V) == len(V_clean) and np.array_equal(F, F_clean)
    metrics = {
        "snr": lambda: snr(V_clean, V) if same else None,
        "normal_angle": lambda: normal_angle(V, V_clean, F) if same else None,
        "surface_distance": lambda: surface_distance(V, V_clean, F_clean),
        "hausdorff": lambda: hausdorff(V, F, V_clean, F_clean),
        "volume_change": lambda: _change(volume(V, F), volume(V_clean, F_clean), "no volume"),
        "area_change": lambda: _change(area(V, F), area(V_clean, F_clean), "no area"),
    }
    return {name: _or_none(metric) for name, metric in metrics.items()}


def _or_none(metric):
    try:
        return metric()
    except MeshError:  # the clean mesh has nothing to compare with
        return None
