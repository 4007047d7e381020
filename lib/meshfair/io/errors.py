"""The errors of the readers and writers, and the four parts that each one names."""

from typing import Any

from meshfair.checks import MeshError

DAMAGED = "the file may be cut or damaged, download or export it again"


class MeshFileError(MeshError):
    """A file that is no mesh, or that cannot be written: which, where, why, and what to do."""


def file_error(place: str, found: str, expected: str, advice: str = DAMAGED) -> MeshFileError:
    """The error to raise: where in the file, what is there (cut), what should be, what to do."""
    return MeshFileError(f"{place}: {found:.300}, but {expected}; {advice}")


def quoted(data: Any) -> str:
    """The beginning of some bytes of a file, fit for a message of one line."""
    return repr(bytes(data[:40]).decode("utf-8", "replace"))


def one_line(error: BaseException) -> str:
    """What another library says, fit for a message of one line."""
    words = " ".join(str(error).split())
    return "".join(c if c.isprintable() else "\ufffd" for c in words)[:200]
