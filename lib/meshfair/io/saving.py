"""Writing so that after any failure the old file or the new one is there, and whole."""

import contextlib
import os
import secrets
import stat
from pathlib import Path

from meshfair.io.errors import file_error


def replace_file(path: Path, data: bytes) -> None:
    """Write a new file next to the old one, and give it the name when it is on the disk.

    Parameters
    ----------
    path : pathlib.Path
        Where it is a link, the file that it points to is replaced. A new file
        has the permissions of the old one.
    data : bytes

    Raises
    ------
    MeshFileError
        No space, no such folder, no permission, ...: the old file is as it was.
        A process that is killed may leave a file .meshfair-*.tmp beside it.
    """
    target = Path(os.path.realpath(path))
    temporary = target.with_name(f".meshfair-{secrets.token_hex(8)}.tmp")
    try:
        old = target.stat() if target.exists() else None
        if old and not (stat.S_ISREG(old.st_mode) and os.access(target, os.W_OK)):
            found = "what has this name is read-only or no regular file"
            raise file_error("writing", found, "it would be replaced", "choose another name")
        with temporary.open("xb") as file:
            if old:
                temporary.chmod(stat.S_IMODE(old.st_mode))
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(target)
    except OSError as error:
        advice = "any old file is as it was; check the folder and the space left, then write again"
        raise file_error(
            "writing", str(error.strerror), "the file has to be whole", advice
        ) from None
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()
