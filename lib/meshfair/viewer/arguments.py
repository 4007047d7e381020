"""The view's arguments: what is for one panel or for each, and what the colours show."""

from __future__ import annotations

from typing import Any

import numpy as np

from meshfair.checks import MeshError, check_choice, check_range, check_text
from meshfair.mesh.objects import arrays, is_object
from meshfair.viewer.panel import CMAPS


def each_mesh(V: Any, F: Any) -> list[tuple[Any, Any]]:
    """Positions and faces for each panel.

    Parameters
    ----------
    V : array_like, another library's mesh, or a list of either
    F : array_like or a list of them; None where ``V`` holds meshes

    Returns
    -------
    list of (V, F)

    Raises
    ------
    MeshError, ValueError
        A mesh that is none, no faces, or lists of different lengths.
    """
    if is_object(V):
        return [arrays(V)]
    if isinstance(V, (list, tuple)) and any(is_object(mesh) for mesh in V):
        return [arrays(mesh) for mesh in V]
    if F is None:
        raise MeshError("F is missing; give the faces, or a mesh of another library for V")
    count = len(V) if _is_list(V, 2) else 1
    return list(zip(each(V, 2, count, "V"), each(F, 2, count, "F"), strict=True))


def each(given: Any, ndim: int, count: int, name: str) -> list[Any]:
    """One entry for each panel: those of a list, or the same for all.

    Parameters
    ----------
    given : object
    ndim : int
        Dimensions of what is for one panel.
    count : int
        Number of panels.
    name : str
        What the message calls it.

    Returns
    -------
    list

    Raises
    ------
    ValueError
        Another number of entries.
    """
    if not _is_list(given, ndim):
        return [given] * count
    return _counted(list(given), count, name)


def each_title(given: Any, count: int) -> list[str]:
    """A title for each panel: a text for all, or one or None for each; empty by default."""
    if given is None or isinstance(given, str):
        return [given or ""] * count
    if not isinstance(given, (list, tuple, np.ndarray)):
        raise ValueError(f"titles is {given!r}; give a text, or a list of one for each panel")
    titles = _counted(list(given), count, "titles")
    return ["" if title is None else check_text(title, "a title") for title in titles]


def coloring(label: Any, limits: Any, cmap: Any) -> tuple[str, tuple[float, float] | None, str]:
    """What the colours show, checked: refused here, not in the thread that draws."""
    limits = None if limits is None else check_range(limits, "limits")
    return check_text(label, "label"), limits, check_choice(cmap, "cmap", CMAPS)


def _counted(entries: list[Any], count: int, name: str) -> list[Any]:
    if len(entries) != count:
        raise ValueError(f"{name} has {len(entries)} entries; give one for each of {count} panels")
    return entries


def _is_list(given: Any, ndim: int) -> bool:
    """Whether something has one entry, of ``ndim`` dimensions or None, a panel."""
    if isinstance(given, np.ndarray) and given.dtype != object:
        return given.ndim == ndim + 1
    if not isinstance(given, (list, tuple, np.ndarray)):
        return False
    return all(entry is None or _ndim(entry) == ndim for entry in given) and len(given) > 0


def _ndim(entry: Any) -> int:
    try:
        return np.ndim(entry)
    except ValueError:
        raise MeshError("an array has rows of different lengths; give rows of three") from None
