"""Which files a process may read and write, by Linux's Landlock; no privilege is needed."""

import ctypes
import os
import struct
import sys
from collections.abc import Iterable
from pathlib import Path

# The same on every architecture that has them (Linux 5.13 and later).
CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446
VERSION_FLAG = 1
PATH_BENEATH = 1
PR_SET_NO_NEW_PRIVS = 38

EXECUTE, WRITE_FILE, READ_FILE, READ_DIR = 1 << 0, 1 << 1, 1 << 2, 1 << 3
READ = EXECUTE | READ_FILE | READ_DIR
OF_FILES = EXECUTE | WRITE_FILE | READ_FILE | 1 << 14  # 14: truncate
# How many rights on files, and on TCP, each version of the interface knows.
FILE_RIGHTS = {1: 13, 2: 14, 3: 15, 4: 15}
ALL_FILE_RIGHTS = 16
TCP_BIND_AND_CONNECT = 0b11


def confine(readable: Iterable[str | Path], writable: Iterable[str | Path]) -> bool:
    """Take from this process, for good, every file but those beneath some folders.

    Also takes TCP, where the kernel knows how. Open files stay open.

    Parameters
    ----------
    readable : iterable of path
        May be read and executed. What does not exist is passed over.
    writable : iterable of path
        May be read, written, made and removed.

    Returns
    -------
    bool
        False where the system has no Landlock; nothing is taken then.
    """
    if sys.platform != "linux":  # elsewhere the numbers mean other calls
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    version = libc.syscall(CREATE_RULESET, None, 0, VERSION_FLAG)
    if version < 1:
        return False
    rights = (1 << FILE_RIGHTS.get(version, ALL_FILE_RIGHTS)) - 1
    attributes = struct.pack("=QQ", rights, TCP_BIND_AND_CONNECT)
    size = 16 if version >= 4 else 8
    ruleset = _checked(libc.syscall(CREATE_RULESET, attributes, size, 0))
    try:
        for paths, allowed in ((readable, READ), (writable, rights)):
            for path in filter(os.path.exists, paths):
                _allow(libc, ruleset, Path(path), allowed & rights)
        _checked(libc.prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0))
        _checked(libc.syscall(RESTRICT_SELF, ruleset, 0))
    finally:
        os.close(ruleset)
    return True


def _allow(libc: ctypes.CDLL, ruleset: int, path: Path, rights: int) -> None:
    parent = os.open(path, os.O_PATH | os.O_CLOEXEC)
    try:
        rights &= ~0 if path.is_dir() else OF_FILES
        rule = struct.pack("=Qi", rights, parent)
        _checked(libc.syscall(ADD_RULE, ruleset, PATH_BENEATH, rule, 0))
    finally:
        os.close(parent)


def _checked(result: int) -> int:
    if result < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return result
