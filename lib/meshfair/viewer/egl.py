"""Whether polyscope can draw without a screen on this machine."""

from __future__ import annotations

import contextlib
import functools
import subprocess
import sys
import warnings
from importlib.util import find_spec

from meshfair.checks import install

PATIENCE = 60  # seconds until a driver that does not answer is given up, once for a process

MISSING_EGL = (
    "polyscope cannot draw here (no EGL), so meshes are drawn with matplotlib; on Debian or "
    "Ubuntu install the packages of apt.txt: libx11-6 libegl1 libgl1 libgl1-mesa-dri"
)
HANGING_EGL = (
    f"the graphics driver did not answer within {PATIENCE} s, so this process draws without it; "
    "with LIBGL_ALWAYS_SOFTWARE=1 in the environment Mesa draws without the graphics card"
)
MISSING_POLYSCOPE = (
    "polyscope is not installed, so meshes are drawn with matplotlib; for shaded pictures run: "
    + install("viewer")
)


def has_egl() -> bool:
    """Whether polyscope is there, and can draw without a screen on this machine.

    Tried in a process of its own, since a GL library that fails can take the
    process with it. The answer is kept: about a second, once.

    Returns
    -------
    bool

    Warns
    -----
    UserWarning
        The graphics driver does not answer; said once, and not waited for again.
    """
    answer = _trial()
    if answer is None:
        _warn_of_hanging()
    return bool(answer)


@functools.cache
def _warn_of_hanging() -> None:
    warnings.warn(HANGING_EGL, UserWarning, stacklevel=3)


@functools.cache
def _trial() -> bool | None:
    """Whether polyscope could draw in a process of its own; None where that did not end."""
    if not has_polyscope():
        return False
    trial = "from meshfair.viewer.offscreen import Scene; Scene()"
    try:
        process = subprocess.Popen(
            [sys.executable, "-c", trial],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
    except OSError:  # no process can be started here
        return False
    try:
        return process.wait(PATIENCE) == 0
    except subprocess.TimeoutExpired:
        process.kill()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(1)  # no longer: what is stuck in a driver may not even die
        return None


def has_polyscope() -> bool:
    """Whether polyscope is installed; whether it loads is another question."""
    return find_spec("polyscope") is not None
