"""Input validation: every argument of a public function is checked here, in one place.

Conventions of the whole package:

* ``V`` is a float64 array of shape (n, 3): one vertex position a row.
* ``F`` is an int64 array of shape (m, 3): one triangle a row, three indices
  into the rows of ``V``, counter-clockwise seen from outside.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array, sparray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]
Choice = TypeVar("Choice")

PACKAGE = str(Path(__file__).parent)
# Products of four coordinates (areas squared) must stay finite in float64.
LARGEST_COORDINATE = 1e75
# Of what is near to what, all lists together: they and their weights take some 3 GB.
MOST_PAIRS = 2e8
# A triangle is degenerate when its height over its longest edge is this small
# a part of that edge: below it, rounding decides the normal and the cotangents.
DEGENERATE = 1e-12
# Or when it is this small a part of the largest coordinate: three points on a line, each
# rounded to float64, make a triangle that high (sqrt(3) eps at most) wherever the mesh lies.
ROUNDED = 4 * float(np.finfo(np.float64).eps)

# Vectors cancel where their sum is this small a part of the sum of their lengths: what is left
# is the rounding of a few thousand terms, which has no direction.
CANCELLED = 1e-12

EXTRAS = {
    "viewer": {"PIL", "matplotlib", "polyscope", "polyscope_bindings"},
    "notebooks": {"anywidget", "ipywidgets", "traitlets"},
    "data": {"pooch"},
    "formats": {"collada", "lxml", "mapbox_earcut", "meshio", "networkx", "trimesh"},
    "experiments": {"pandas", "tqdm"},
    "cluster": {"dask", "distributed"},
    "grading": {"jinja2", "jupytext", "markupsafe", "nbformat", "psutil"},
}
"""Modules that are imported for some uses alone, by the extra that installs them."""


class MeshError(ValueError):
    """Input that is no mesh; the message says what, where, and what to do."""


class MeshWarning(UserWarning):
    """A mesh that can be used, with something about it that one should know."""


class StabilityWarning(UserWarning):
    """A time step past the bound up to which the flow is stable."""


def warn(message: str, category: type[Warning] = MeshWarning) -> None:
    """Warn, and name the line that called the package, whatever lies between.

    Parameters
    ----------
    message : str
    category : type of Warning
    """
    level, frame = 1, sys._getframe(0)
    while frame.f_back and frame.f_code.co_filename.startswith(PACKAGE):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, category, stacklevel=level)


class NotInstalledError(ModuleNotFoundError):
    """An optional library that is missing; the message says what to install."""


def _array(values: ArrayLike, name: str, kinds: str, wanted: str) -> NDArray[Any]:
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


def check_vertices(V: ArrayLike, name: str = "V", *, values: bool = True) -> Floats:
    """Validate vertex positions.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        Vertex positions, in any unit of length.
    name : str
        What the message calls the array.
    values : bool
        Check the coordinates too. A step that looks at each of them anyway spares that.

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
    if values and not (-LARGEST_COORDINATE <= V.min() and V.max() <= LARGEST_COORDINATE):
        row, column = np.argwhere(~(np.abs(V) <= LARGEST_COORDINATE))[0]
        raise MeshError(
            f"{name}: vertex {row} has {'xyz'[column]} = {V[row, column]}; coordinates must be "
            f"finite and of a size up to {LARGEST_COORDINATE:g}, so remove or repair this vertex"
        )
    return V


def check_faces(F: ArrayLike, n: int, name: str = "F") -> Integers:
    """Validate triangles.

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


def check_mesh(V: ArrayLike, F: ArrayLike) -> tuple[Floats, Integers]:
    """Validate a mesh.

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


def check_same_vertices(
    V: ArrayLike, other: ArrayLike, names: tuple[str, str] = ("V", "the other mesh")
) -> tuple[Floats, Floats]:
    """Validate two meshes whose vertices are compared one by one.

    Parameters
    ----------
    V, other : array_like, shape (n, 3)
    names : pair of str
        What messages call the two.

    Returns
    -------
    V, other : ndarray of float64, shape (n, 3)

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


def check_number(
    value: Any, name: str, low: float, high: float = np.inf, *, open_low: bool = False
) -> float:
    """Validate a finite number between two bounds.

    Parameters
    ----------
    value : object
    name : str
        What the message calls it.
    low, high : float
        The bounds, themselves allowed where they are finite.
    open_low : bool
        Whether the lower bound itself is refused.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        Not a real number, not finite, or outside [low, high]
        (outside (low, high] with ``open_low``).
    """
    wanted = f"a number {'above' if open_low else 'of at least'} {low:g}"
    wanted += "" if high == np.inf else f" and at most {high:g}"
    if (low, high) == (-np.inf, np.inf):
        wanted = "a finite number"
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}; give {wanted}") from None
    inside = low < number <= high if open_low else low <= number <= high
    if not (np.isfinite(number) and inside):
        raise ValueError(f"{name} is {value!r}; give {wanted}")
    return number


def check_count(value: Any, name: str, low: int = 0) -> int:
    """Validate a whole number.

    Parameters
    ----------
    value : object
    name : str
        What the message calls it.
    low : int
        The least that is allowed.

    Returns
    -------
    int

    Raises
    ------
    ValueError
        Not a whole number, or below ``low``.
    """
    if not isinstance(value, Integral) or isinstance(value, bool) or value < low:
        raise ValueError(f"{name} is {value!r}; give a whole number of at least {low}")
    return int(value)


def check_choice(value: Choice, name: str, choices: Iterable[Choice]) -> Choice:
    """Validate one of several choices.

    Parameters
    ----------
    value : object
    name : str
        What the message calls it.
    choices : iterable
        What is allowed.

    Returns
    -------
    object
        The choice that is equal to ``value``.

    Raises
    ------
    ValueError
        None of the choices; the message lists them.
    """
    choices = list(choices)
    for choice in choices:
        try:
            if value is choice or value == choice:
                return choice
        except ValueError:  # an array, which is equal to nothing as a whole
            break
    listed = ", ".join(str(choice) for choice in choices)
    raise ValueError(f"{name} is {value!r}; give one of {listed}{did_you_mean(value, choices)}")


def did_you_mean(word: Any, known: Iterable[Any]) -> str:
    """A part of a message: which of the known words was meant, if one is close.

    Parameters
    ----------
    word : object
    known : iterable

    Returns
    -------
    str
        " (did you mean 'taubin'?)", or nothing.
    """
    from difflib import get_close_matches  # for an error alone

    names = {other.lower(): other for other in known if isinstance(other, str)}
    close = get_close_matches(word.lower(), names, n=1) if isinstance(word, str) else []
    return f" (did you mean {names[close[0]]!r}?)" if close else ""


def check_text(text: Any, name: str) -> str:
    """Validate a text.

    Parameters
    ----------
    text : object
    name : str
        What the message calls it.

    Returns
    -------
    str

    Raises
    ------
    ValueError
        Anything but a str.
    """
    if not isinstance(text, str):
        raise ValueError(f"{name} is {text!r}; give a text")
    return str(text)


def check_flag(flag: Any, name: str) -> bool:
    """Validate a yes or no.

    Parameters
    ----------
    flag : object
    name : str
        What the message calls it.

    Returns
    -------
    bool

    Raises
    ------
    ValueError
        Neither True nor False.
    """
    if not isinstance(flag, (bool, np.bool_)):
        raise ValueError(f"{name} is {flag!r}; give True or False")
    return bool(flag)


def check_size(size: Any, name: str, low: int, high: int) -> tuple[int, int]:
    """Validate a picture's width and height.

    Parameters
    ----------
    size : object
    name : str
        What the message calls it.
    low, high : int
        The least and the most pixels of either.

    Returns
    -------
    (int, int)

    Raises
    ------
    ValueError
        Not two whole numbers, or outside of [low, high].
    """
    try:
        width, height = (check_count(pixels, name) for pixels in size)
    except (TypeError, ValueError):
        width = height = -1
    if not (low <= width <= high and low <= height <= high):
        raise ValueError(
            f"{name} is {size!r}; give width and height as two whole numbers of pixels from "
            f"{low} to {high}"
        )
    return width, height


def check_values(
    values: ArrayLike, n: int, m: int, name: str = "values", *, finite: bool = True
) -> Floats:
    """Validate one number for each vertex, or for each face.

    Parameters
    ----------
    values : array_like, shape (n,) or (m,)
    n, m : int
        Number of vertices, and of faces.
    name : str
        What the message calls them.
    finite : bool
        Whether NaN and infinite values are refused.

    Returns
    -------
    ndarray of float64, shape (n,) or (m,)
        A new array.

    Raises
    ------
    MeshError
        Another shape, not real numbers, NaN or infinite values.
    """
    wanted = f"give one number for each of the {n} vertices or of the {m} faces"
    try:
        array = np.asarray(values)
    except ValueError:
        raise MeshError(f"{name} has entries of different lengths; {wanted}") from None
    if array.dtype.kind not in "biuf":
        raise MeshError(f"{name} holds values of type {array.dtype}; {wanted}")
    if array.shape not in ((n,), (m,)):
        raise MeshError(f"{name} has shape {array.shape}; {wanted}")
    if finite and not np.isfinite(array).all():
        row = np.flatnonzero(~np.isfinite(array))[0]
        raise MeshError(f"{name}: number {row} is {array[row]}; give finite numbers")
    return array.astype(np.float64)


def check_range(limits: Any, name: str) -> tuple[float, float]:
    """Validate the two ends of a range.

    Parameters
    ----------
    limits : object
    name : str
        What the message calls them.

    Returns
    -------
    (float, float)

    Raises
    ------
    ValueError
        Not two finite numbers, the smaller one first.
    """
    ends = _few_numbers(limits, 2)
    if ends is None or ends[0] > ends[1]:
        raise ValueError(f"{name} is {limits!r}; give two numbers, the smaller one first")
    return float(ends[0]), float(ends[1])


def _few_numbers(given: Any, count: int) -> Floats | None:
    """So many finite numbers; None for anything else."""
    try:
        array = np.asarray(given)
    except ValueError:
        return None
    if array.dtype.kind not in "iuf" or array.shape != (count,) or not np.isfinite(array).all():
        return None
    return array.astype(np.float64)


def check_direction(direction: Any, name: str) -> Floats:
    """Validate a direction in space.

    Parameters
    ----------
    direction : object
    name : str
        What the message calls it.

    Returns
    -------
    ndarray of float64, shape (3,)
        Of length 1.

    Raises
    ------
    ValueError
        Not three finite numbers, or all of them zero.
    """
    vector = _few_numbers(direction, 3)
    if vector is None or not vector.any():
        raise ValueError(f"{name} is {direction!r}; give three numbers that are not all zero")
    vector /= np.abs(vector).max()  # so that no square overflows, or vanishes
    return vector / np.linalg.norm(vector)


def check_point(point: Any, name: str) -> tuple[float, float, float]:
    """Validate a point in space.

    Parameters
    ----------
    point : object
    name : str
        What the message calls it.

    Returns
    -------
    (float, float, float)

    Raises
    ------
    ValueError
        Not three finite numbers.
    """
    vector = _few_numbers(point, 3)
    if vector is None:
        raise ValueError(f"{name} is {point!r}; give three finite numbers")
    a, b, c = vector.tolist()
    return a, b, c


def check_rng(rng: Any) -> np.random.Generator:
    """Validate a generator of random numbers.

    Parameters
    ----------
    rng : object

    Returns
    -------
    numpy.random.Generator

    Raises
    ------
    TypeError
        Anything but a `numpy.random.Generator`.
    """
    if not isinstance(rng, np.random.Generator):
        raise TypeError(f"rng is {rng!r}; give a generator, such as numpy.random.default_rng(7)")
    return rng


def check_fixed(fixed: ArrayLike | None, n: int) -> Booleans:
    """Validate the constrained vertices, which keep their place.

    Parameters
    ----------
    fixed : array_like or None
        A boolean mask of shape (n,), or indices of vertices; None for no vertex.
    n : int
        Number of vertices.

    Returns
    -------
    ndarray of bool, shape (n,)
        A new array.

    Raises
    ------
    MeshError
        A mask of another length, or an index outside 0 .. n - 1.
    """
    mask = np.zeros(n, dtype=bool)
    if fixed is None:
        return mask
    fixed = np.asarray(fixed)
    if fixed.dtype == bool:
        if fixed.shape != (n,):
            raise MeshError(f"fixed has shape {fixed.shape}; a mask needs ({n},), one a vertex")
        return fixed.copy()
    if fixed.size == 0:
        return mask
    if fixed.dtype.kind not in "iu":
        raise MeshError(f"fixed is of type {fixed.dtype}; give a boolean mask or vertex indices")
    if fixed.ndim != 1:
        raise MeshError(
            f"fixed has shape {fixed.shape}; give a boolean mask or vertex indices in one row"
        )
    if fixed.min() < 0 or fixed.max() >= n:
        bad = fixed[(fixed < 0) | (fixed >= n)][0]
        raise MeshError(f"fixed has vertex index {bad}, but there are {n} vertices (0 to {n - 1})")
    mask[fixed] = True
    return mask


def check_square(A: sparray | ArrayLike, name: str = "A") -> csr_array:
    """Validate a square sparse matrix.

    Parameters
    ----------
    A : sparse array, shape (n, n)
    name : str
        What the message calls it.

    Returns
    -------
    csr_array of float64, shape (n, n)
        The input itself where it is one already; never written to.

    Raises
    ------
    MeshError
        Not square, not finite, or an entry in a column that does not exist.
    """
    A = _square(A, name)
    # A sum shows in one pass whether any entry is not finite; only a bad array is searched.
    with np.errstate(over="ignore", invalid="ignore"):
        suspicious = not np.isfinite(A.data.sum())
    if suspicious and not np.isfinite(A.data).all():
        raise MeshError(f"{name} holds NaN or infinite entries; build it from a checked mesh")
    if A.nnz and A.indices.view(A.indices.dtype.str.replace("i", "u")).max() >= A.shape[1]:
        raise MeshError(f"{name} has an entry in a column that it does not have; build it anew")
    return A


def check_operator(A: sparray | ArrayLike, n: int, *, entries: bool = True) -> csr_array:
    """Validate an operator on the positions of n vertices.

    Parameters
    ----------
    A : sparse array, shape (n, n)
    n : int
        Number of vertices.
    entries : bool
        Check the entries too. A step that looks at each of them anyway spares that.

    Returns
    -------
    csr_array of float64, shape (n, n)
        The input itself where it is one already; never written to.

    Raises
    ------
    MeshError
        Not of shape (n, n), not finite, or an entry in a column that does not exist.
    """
    if np.shape(A) != (n, n):
        raise MeshError(
            f"the operator has shape {np.shape(A)}, but V has {n} vertices; "
            "build it from the same mesh"
        )
    return check_square(A, "A") if entries else _square(A, "A")


def _square(A: sparray | ArrayLike, name: str) -> csr_array:
    """A square matrix as csr_array of float64, its entries as they are."""
    from scipy.sparse import csr_array  # a tenth of a second to load, which not everybody needs

    shape = np.shape(A)
    if len(shape) != 2 or shape[0] != shape[1]:
        raise MeshError(f"{name} has shape {shape}; give a square sparse matrix")
    if isinstance(A, csr_array) and A.dtype == np.float64:
        return A
    return csr_array(A, dtype=np.float64)


@contextmanager
def needed_for(purpose: str) -> Iterator[None]:
    """Import optional libraries in this block, or say in one sentence what to install.

    Parameters
    ----------
    purpose : str
        What needs them; the message's beginning.

    Raises
    ------
    NotInstalledError
        A library is missing, or does not load here.
    """
    try:
        yield
    except ImportError as error:
        library = (error.name or "a library").split(".")[0]
        if library == "meshfair":  # an error of ours, which no installation mends
            raise
        extra = next((name for name, modules in EXTRAS.items() if library in modules), "all")
        reason = str(error).splitlines()[0]
        raise NotInstalledError(
            f"{purpose} needs {library} ({reason}); run: {install(extra)}", name=error.name
        ) from None


def install(extra: str) -> str:
    """The command that installs the libraries of an extra.

    Parameters
    ----------
    extra : str

    Returns
    -------
    str
    """
    return f'pip install "meshfair[{extra}]"'
