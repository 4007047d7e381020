"""The gate: every array that enters the package is checked here, in one place.

Conventions of the whole package:

* ``V`` is a float64 array of shape (n, 3): one vertex position a row.
* ``F`` is an int64 array of shape (m, 3): one triangle a row, three indices
  into the rows of ``V``, counter-clockwise seen from outside.
"""

import numpy as np

# Products of four coordinates (areas squared) must stay finite in float64.
LARGEST_COORDINATE = 1e75


class MeshError(ValueError):
    """Input that is no mesh; the message says what, where, and what to do."""


class MeshWarning(UserWarning):
    """A mesh that can be used, with something about it that one should know."""


class StabilityWarning(UserWarning):
    """A time step past the bound up to which the flow is stable."""


def _array(values, name, kinds, wanted):
    """Turn ``values`` into an array whose dtype is of one of ``kinds``."""
    try:
        array = np.asarray(values)
    except ValueError:
        raise MeshError(f"{name} has rows of different lengths; give {wanted}") from None
    if array.dtype.kind not in kinds:
        raise MeshError(f"{name} holds values of type {array.dtype}; give {wanted}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"{name} has shape {array.shape}; give {wanted}")
    return array


def check_vertices(V, name="V"):
    """Return vertex positions as float64 of shape (n, 3), or say why not.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        Vertex positions, in any unit of length.
    name : str
        What the message calls the array.

    Returns
    -------
    V : ndarray of float64, shape (n, 3), C-contiguous
        The input itself where it is one already; never written to.

    Raises
    ------
    MeshError
        Wrong shape, not real numbers, NaN, infinite or absurdly large values.
    """
    V = _array(V, name, "iuf", "real numbers of shape (n, 3), one vertex a row")
    V = np.ascontiguousarray(V, dtype=np.float64)
    if not len(V):
        raise MeshError(f"{name} has no vertices; a mesh needs at least three")
    # NaN compares as False. Only a bad array is searched.
    if not (-LARGEST_COORDINATE <= V.min() and V.max() <= LARGEST_COORDINATE):
        row, column = np.argwhere(~(np.abs(V) <= LARGEST_COORDINATE))[0]
        raise MeshError(
            f"{name}: vertex {row} has {'xyz'[column]} = {V[row, column]}; coordinates must be "
            f"finite and of a size up to {LARGEST_COORDINATE:g}, so remove or repair this vertex"
        )
    return V


def check_faces(F, n, name="F"):
    """Return triangles as int64 of shape (m, 3), or say why not.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)
        Vertex indices of each triangle.
    n : int
        Number of vertices.
    name : str
        What the message calls the array.

    Returns
    -------
    F : ndarray of int64, shape (m, 3), C-contiguous

    Raises
    ------
    MeshError
        Wrong shape, not integers, no faces, or an index outside 0 .. n - 1.
    """
    if np.size(F) == 0:
        raise MeshError(f"{name} has no faces; a mesh needs at least one triangle")
    F = _array(F, name, "iu", "integers of shape (m, 3), one triangle a row")
    checked = np.ascontiguousarray(F, dtype=np.int64)
    # One pass decides: read as unsigned, a negative number is larger than any index.
    if checked.view(np.uint64).max() >= n:
        row = np.argwhere((F < 0) | (F >= n))[0][0]
        bad = next(int(i) for i in F[row] if not 0 <= i < n)
        raise MeshError(
            f"{name}: face {row} has vertex index {bad}, but there are {n} vertices "
            f"(0 to {n - 1}); check that indices start at 0 and that no vertex was dropped"
        )
    return checked


def check_mesh(V, F):
    """Return ``(V, F)`` as the package's arrays, or say what is wrong with them.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        Vertex positions, in any unit of length.
    F : array_like of integers, shape (m, 3)
        Vertex indices of each triangle.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Raises
    ------
    MeshError
        A ValueError with one sentence: what is wrong, the first row where it
        is, and what to do. See `check_vertices` and `check_faces`.
    """
    V = check_vertices(V)
    return V, check_faces(F, len(V))


def check_same_vertices(V, other, names=("V", "the other mesh")):
    """Return two vertex arrays of one shape, or say that they cannot be compared.

    Raises
    ------
    MeshError
        As `check_vertices`, or where the numbers of vertices differ.
    """
    V, other = check_vertices(V, names[0]), check_vertices(other, names[1])
    if len(V) != len(other):
        raise MeshError(
            f"{names[0]} has {len(V)} vertices but {names[1]} has {len(other)}; vertices are "
            "compared one by one, so both meshes need the same number in the same order"
        )
    return V, other


def check_number(value, name, low, high=np.inf, *, open_low=False):
    """Return a finite float between two bounds, or say why not.

    Raises
    ------
    ValueError
        Not a real number, not finite, or outside [low, high]
        (outside (low, high] with ``open_low``).
    """
    wanted = f"a number {'above' if open_low else 'of at least'} {low:g}"
    wanted += "" if high == np.inf else f" and at most {high:g}"
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}; give {wanted}") from None
    inside = low < number <= high if open_low else low <= number <= high
    if not (np.isfinite(number) and inside):
        raise ValueError(f"{name} is {value!r}; give {wanted}")
    return number


def check_rng(rng):
    """Return the generator of random numbers, or say that it is none.

    Raises
    ------
    TypeError
        Anything but a `numpy.random.Generator`.
    """
    if not isinstance(rng, np.random.Generator):
        raise TypeError(f"rng is {rng!r}; give a generator, such as numpy.random.default_rng(7)")
    return rng
