"""How a process of root gives its rights away, and still finds its own Python."""

import ctypes
import os
import struct

PR_SET_KEEPCAPS = 8
CAPABILITY_VERSION = 0x20080522
CAP_DAC_READ_SEARCH = 1 << 2


def become(user: int, *, keep_reading: bool) -> None:
    """Turn a process of root into one of another user, for good.

    Parameters
    ----------
    user : int
        User and group.
    keep_reading : bool
        Go on reading files that are root's alone. For a process that Landlock
        confines to Python's files, which may lie in root's home.

    Raises
    ------
    OSError
        The process may not do that.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    if keep_reading and libc.prctl(PR_SET_KEEPCAPS, 1, 0, 0, 0):
        raise OSError(ctypes.get_errno(), "the capabilities cannot be kept")
    os.setgroups([])
    os.setgid(user)
    os.setuid(user)
    if keep_reading:
        header = struct.pack("=Ii", CAPABILITY_VERSION, 0)
        # Effective, permitted, inheritable: of the first 32 capabilities, then of the others.
        sets = struct.pack("=6I", CAP_DAC_READ_SEARCH, CAP_DAC_READ_SEARCH, 0, 0, 0, 0)
        if libc.capset(header, sets):
            raise OSError(ctypes.get_errno(), "the capabilities cannot be set")
