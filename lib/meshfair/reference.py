"""libigl's matrices in this package's conventions, to compare the hand-written ones with.

References
----------
.. [libigl] A. Jacobson, D. Panozzo, and others, "libigl: A simple C++ geometry processing
   library", 2018.
"""

import igl
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, diags_array

from meshfair.checks import check_faces, check_mesh


def adjacency(F: ArrayLike, n: int) -> csr_array:
    """libigl's adjacency matrix [libigl]_, as `meshfair.weights.combinatorial` gives it.

    libigl's size is the largest index plus one; here it is always (n, n).

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)
    n : int
        Number of vertices.

    Returns
    -------
    csr_array of float64, shape (n, n)

    Raises
    ------
    MeshError
        No triangles, or an index out of range.
    """
    F = check_faces(F, n)
    A = csr_array(igl.adjacency_matrix(F), dtype=float)
    A.resize((n, n))
    return A


def cotangent(V: ArrayLike, F: ArrayLike) -> csr_array:
    """libigl's cotangent matrix [libigl]_, as `meshfair.weights.cotangent` gives its weights.

    ``igl.cotmatrix`` is -L: negative semidefinite, with w_ij = (cot + cot) / 2
    off the diagonal. It counts a duplicate face twice, and gives NaN where a
    face is degenerate.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    csr_array of float64, shape (n, n)

    Raises
    ------
    MeshError
        No mesh.
    """
    V, F = check_mesh(V, F)
    C = csr_array(igl.cotmatrix(V, F))
    return csr_array(C - diags_array(C.diagonal()))


def mass(V: ArrayLike, F: ArrayLike) -> csr_array:
    """libigl's barycentric mass matrix [libigl]_, as `meshfair.operators.mass` gives it.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    csr_array of float64, shape (n, n)

    Raises
    ------
    MeshError
        No mesh.
    """
    V, F = check_mesh(V, F)
    M = csr_array(igl.massmatrix(V, F, igl.MASSMATRIX_TYPE_BARYCENTRIC))
    M.resize((len(V), len(V)))
    return M
