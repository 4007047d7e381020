"""Arguments lent to a student's process: in memory that both processes see.

So whether a function changed what it was given is seen from outside, and does not have
to be believed.
"""

import fcntl
import mmap
import os
import socket
import tempfile
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

ALIGNMENT = 64  # bytes


class Lent:
    """The arguments of one call, and the memory in which they lie.

    Parameters
    ----------
    arguments : sequence
        Arrays and sparse matrices are lent; the rest travels with the layout.

    Attributes
    ----------
    layout : list
        Plain data that says where each argument lies.
    """

    def __init__(self, arguments: Sequence[Any]) -> None:
        self._content = bytearray()
        self._places: list[list[tuple[int, NDArray[Any]]]] = []
        self.layout = [self._lay(argument) for argument in arguments]
        self._file = _memory(bytes(self._content))

    def _lay(self, argument: Any) -> dict[str, Any]:
        parts: list[NDArray[Any]] = []
        if isinstance(argument, np.ndarray):
            parts = [np.array(argument, order="C")]
        elif isinstance(argument, csr_array):
            # SciPy itself brings a matrix into this form, in place.
            matrix = argument.copy()
            matrix.sum_duplicates()
            parts = [matrix.data, matrix.indices, matrix.indptr]
        places = []
        for part in parts:
            self._content += bytes(-len(self._content) % ALIGNMENT)
            places.append((len(self._content), part))
            self._content += part.tobytes()
        self._places.append(places)
        if not parts:
            return {"value": argument}
        described = [[part.dtype.str, list(part.shape), start] for start, part in places]
        return {"parts": described, "shape": list(argument.shape)}

    def send(self, channel: socket.socket) -> None:
        """Lend the memory to the process at the other end.

        Parameters
        ----------
        channel : socket.socket
        """
        socket.send_fds(channel, [b"+"], [self._file])

    def changed(self) -> set[int]:
        """Positions of the arguments that are no longer as they were.

        Returns
        -------
        set of int
        """
        return {
            index
            for index, places in enumerate(self._places)
            if not all(self._same(start, part) for start, part in places)
        }

    def _same(self, start: int, before: NDArray[Any]) -> bool:
        content = os.pread(self._file, before.nbytes, start)
        if content == before.tobytes():
            return True
        if len(content) < before.nbytes:
            return False
        after = np.frombuffer(content, before.dtype).reshape(before.shape)
        return bool(np.array_equal(before, after, equal_nan=before.dtype.kind in "fc"))

    def close(self) -> None:
        """Give the memory back."""
        os.close(self._file)


def borrow(channel: socket.socket, layout: list[dict[str, Any]]) -> list[Any]:
    """The arguments of a call, in the lent memory.

    Parameters
    ----------
    channel : socket.socket
    layout : list of dict
        See `Lent.layout`.

    Returns
    -------
    list
    """
    _, files, _, _ = socket.recv_fds(channel, 1, 1)
    memory = mmap.mmap(files[0], 0)
    os.close(files[0])
    return [_taken(place, memory) for place in layout]


def _taken(place: dict[str, Any], memory: mmap.mmap) -> Any:
    if "value" in place:
        return place["value"]
    parts = [
        np.frombuffer(memory, dtype, int(np.prod(shape)), start).reshape(shape)
        for dtype, shape, start in place["parts"]
    ]
    return csr_array(tuple(parts), shape=tuple(place["shape"])) if len(parts) == 3 else parts[0]


def _memory(content: bytes) -> int:
    """A file in memory, whose size is fixed where the system knows how."""
    if not hasattr(os, "memfd_create"):
        with tempfile.TemporaryFile() as file:
            file.write(content or b"\0")
            file.flush()
            return os.dup(file.fileno())
    descriptor = os.memfd_create("arguments", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    with open(descriptor, "wb", closefd=False) as file:
        file.write(content or b"\0")
    seals = fcntl.F_SEAL_SEAL | fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW
    fcntl.fcntl(descriptor, fcntl.F_ADD_SEALS, seals)
    return descriptor
