"""The rows of a sweep on the disk, as they are finished."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO

from meshfair.experiments.cells import Row

# What was written is safe from the end of this process at once, and from that of the machine
# after this time; to wait for the disk takes longer than a small cell.
SYNC_SECONDS = 1.0


def read(path: str | os.PathLike[str]) -> dict[str, Row]:
    """The rows that earlier sweeps have finished, by their cells' keys.

    Parameters
    ----------
    path : path
        A line cut short by a kill is none; a file that is not there has none.

    Returns
    -------
    dict of str to dict
        The last row of each key.
    """
    rows: dict[str, Row] = {}
    if not Path(path).exists():
        return rows
    with open(path, "rb") as file:
        for line in file:
            try:
                row = json.loads(line)
                rows[row.pop("key")] = row
            except (ValueError, KeyError, AttributeError, TypeError):
                continue
    return rows


class Journal:
    """Appends rows to a file, each as a line of JSON that nobody changes any more.

    Parameters
    ----------
    path : path or None
        Without one, nothing is kept.
    """

    def __init__(self, path: str | os.PathLike[str] | None) -> None:
        self._path = path
        self._file: BinaryIO | None = None
        self._synced = 0.0

    def __enter__(self) -> Journal:
        if self._path:
            Path(self._path).parent.mkdir(parents=True, exist_ok=True)
            self._file = open(self._path, "ab")
            self._file.write(b"\n")  # ends a line that a kill left unfinished
        return self

    def append(self, rows: Iterable[tuple[str, Row]]) -> None:
        """Write rows with their keys, and hand them to the system.

        Parameters
        ----------
        rows : iterable of (str, dict)
        """
        if self._file is None:
            return
        self._file.writelines(json.dumps({"key": key, **row}).encode() + b"\n" for key, row in rows)
        self._file.flush()
        if time.monotonic() - self._synced > SYNC_SECONDS:
            os.fsync(self._file.fileno())
            self._synced = time.monotonic()

    def __exit__(self, *_: object) -> None:
        if self._file:
            os.fsync(self._file.fileno())
            self._file.close()
