"""Plain data over a socket: JSON for the structure, raw bytes for the arrays, no pickle.

A message is the length of its head, the length of its body (8 bytes each),
the head, the body. What is read is checked before it is believed: the other
side may be a student's process.
"""

import json
import socket
import struct
import time
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from meshfair_grading.answers import LARGEST_ANSWER, Answer, Failure, Other, Seeded

LENGTHS = struct.Struct("<QQ")
LARGEST_HEAD = 1_000_000
LARGEST_BODY = 4 * LARGEST_ANSWER
DTYPES = {"|b1", "<i8", "<f8", "<c16"}


class ProtocolError(ValueError):
    """A message that no honest process sends."""


def send(channel: socket.socket, data: Any) -> None:
    """Send plain data.

    Parameters
    ----------
    channel : socket.socket
    data : object
        dict with string keys, list, str, number, bool, None, ndarray of bool,
        int64, float64 or complex128, csr_array, `Seeded`, `Other`, `Answer`.
    """
    buffers: list[bytes] = []
    head = json.dumps(_pack(data, buffers)).encode()
    body = b"".join(buffers)
    channel.sendall(LENGTHS.pack(len(head), len(body)) + head + body)


def receive(channel: socket.socket, deadline: float | None = None) -> Any:
    """Receive what `send` sent.

    Parameters
    ----------
    channel : socket.socket
    deadline : float, optional
        Value of ``time.monotonic()`` up to which to wait.

    Returns
    -------
    object

    Raises
    ------
    TimeoutError
        Past the deadline.
    EOFError
        The other side has closed the channel, or died.
    ProtocolError
        Not a message.
    """
    head_length, body_length = LENGTHS.unpack(_read(channel, LENGTHS.size, deadline))
    if head_length > LARGEST_HEAD or body_length > LARGEST_BODY:
        raise ProtocolError("the message is larger than any answer")
    head = _read(channel, head_length, deadline)
    body = _read(channel, body_length, deadline)
    try:
        return _unpack(json.loads(head), memoryview(body))
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise ProtocolError(f"the message makes no sense ({error})") from error


def _read(channel: socket.socket, length: int, deadline: float | None) -> bytearray:
    data = bytearray(length)
    rest = memoryview(data)
    while rest:
        if deadline is not None:
            left = deadline - time.monotonic()
            if left <= 0:
                raise TimeoutError
            channel.settimeout(left)
        count = channel.recv_into(rest)
        if not count:
            raise EOFError
        rest = rest[count:]
    return data


def _pack(data: Any, buffers: list[bytes]) -> Any:
    """The structure for JSON; arrays go to ``buffers`` and leave a description."""
    match data:
        case np.ndarray():
            start = sum(map(len, buffers))
            buffers.append(data.tobytes())
            return {"$": "array", "dtype": data.dtype.str, "shape": data.shape, "start": start}
        case csr_array():
            # Rows and columns can be checked one by one; a broken CSR can crash SciPy.
            matrix = data.tocoo()
            parts = matrix.row.astype(np.int64), matrix.col.astype(np.int64), matrix.data
            return {"$": "sparse", "shape": data.shape, "parts": [_pack(p, buffers) for p in parts]}
        case Seeded() | Other() | Failure():
            return {"$": type(data).__name__, **asdict(data)}
        case Answer():
            return {
                "$": "Answer",
                "value": _pack(data.value, buffers),
                "changed": list(data.changed),
                "failure": _pack(data.failure, buffers),
            }
        case dict():
            return {key: _pack(value, buffers) for key, value in data.items()}
        case list() | tuple():
            return [_pack(item, buffers) for item in data]
    return data


def _unpack(packed: Any, body: memoryview) -> Any:
    match packed:
        case {"$": "array", "dtype": dtype, "shape": shape, "start": start}:
            return _array(dtype, shape, start, body)
        case {"$": "sparse", "shape": [n, m], "parts": parts}:
            return _sparse(n, m, *(_unpack(part, body) for part in parts))
        case {"$": "Seeded", "seed": seed}:
            return Seeded(int(seed))
        case {"$": "Other", "type": name, "shown": shown}:
            return Other(str(name), str(shown))
        case {"$": "Failure", "kind": kind, "message": message, "line": line, "code": code}:
            return Failure(str(kind), str(message), int(line), str(code))
        case {"$": "Answer", "value": value, "changed": changed, "failure": failure}:
            failure = _unpack(failure, body)
            if not isinstance(failure, Failure | None):
                raise ProtocolError("a failure is expected")
            return Answer(_unpack(value, body), tuple(map(int, changed)), failure)
        case {"$": other}:
            raise ProtocolError(f"no type {other!r}")
        case dict():
            return {key: _unpack(value, body) for key, value in packed.items()}
        case list():
            return [_unpack(item, body) for item in packed]
    return packed


def _array(dtype: Any, shape: Any, start: Any, body: memoryview) -> NDArray[Any]:
    shape, start = [int(size) for size in shape], int(start)
    if dtype not in DTYPES or len(shape) > 8 or min([start, *shape]) < 0:
        raise ProtocolError(f"no array of type {dtype!r} and shape {shape}")
    dtype = np.dtype(dtype)
    count = 1
    for size in shape:  # in Python's integers, which do not overflow
        count *= size
    if start + count * dtype.itemsize > len(body):
        raise ProtocolError("an array that is longer than its bytes")
    return np.frombuffer(body, dtype, count, start).reshape(shape).copy()


def _sparse(n: Any, m: Any, row: Any, col: Any, data: Any) -> csr_array:
    # A matrix takes memory for its rows even where it has no entries.
    if not (0 <= n <= LARGEST_ANSWER and 0 <= m <= LARGEST_ANSWER):
        raise ProtocolError("a sparse matrix larger than any answer")
    if not (row.ndim == 1 and row.shape == col.shape == data.shape):
        raise ProtocolError("a sparse matrix with parts of different lengths")
    if len(row) and not (0 <= row.min() <= row.max() < n and 0 <= col.min() <= col.max() < m):
        raise ProtocolError("a sparse matrix with entries outside")
    return csr_array(coo_array((data, (row, col)), shape=(int(n), int(m))))
