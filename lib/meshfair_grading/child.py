"""The process in which a student's code runs: loads the file, answers calls.

Started by ``isolation`` with the words CHANNEL LIMITS USER, in JSON.
Only requests come in and values go out; no right answer is ever here.
"""

import importlib
import json
import os
import resource
import socket
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import scipy.sparse.linalg  # noqa: F401  here once, so that no student's time limit pays for it

from meshfair_grading import landlock, privileges, protocol
from meshfair_grading.answers import Answer, Failure, ask, failure
from meshfair_grading.loading import load
from meshfair_grading.rules import ImportBlocker, Rules

# What Python and its libraries read beside their own files.
SYSTEM = ("/usr", "/lib", "/lib64", "/bin", "/etc/ld.so.cache", "/etc/localtime", "/proc/self")
DEVICES = ("/dev/null", "/dev/zero", "/dev/random", "/dev/urandom")


def main(descriptor: int, limits: dict[str, int], user: int | None) -> None:
    """Answer calls until the channel is closed.

    Parameters
    ----------
    descriptor : int
        File descriptor of the socket to the teacher's process.
    limits : dict of str to int
        cpu in seconds, memory and file in bytes, processes, files.
    user : int or None
        Whom to become.
    """
    channel = socket.socket(fileno=descriptor)
    confined = landlock.confine(
        [*SYSTEM, sys.prefix, sys.base_prefix, *sys.path, Path(__file__).parents[1]],
        [*DEVICES, Path.cwd()],
    )
    if user is not None:
        privileges.become(user, keep_reading=confined)
    _limit(limits)
    # Restrictions that hide Python from itself show here, not in a student's marks.
    importlib.import_module("colorsys")
    protocol.send(channel, {"confined": confined})
    request = protocol.receive(channel)
    file = request["load"]
    rules = Rules(*(tuple(request[key]) for key in ("allowed", "forbidden", "blocked")))
    module, said = _load(file, rules)
    protocol.send(channel, said)
    while True:
        try:
            request = protocol.receive(channel)
        except EOFError:
            return
        function = getattr(module, request["call"], None)
        if callable(function):
            answer = ask(function, request["arguments"], file)
        else:
            answer = Answer(failure=Failure("missing", request["call"]))
        try:
            protocol.send(channel, answer)
        except BaseException:  # the student has closed the channel: no traceback of ours helps
            os._exit(1)


def _limit(limits: dict[str, int]) -> None:
    if sys.platform == "darwin":
        limits = {name: value for name, value in limits.items() if name != "memory"}  # no such one
    for name, value in limits.items():
        kind = {
            "cpu": resource.RLIMIT_CPU,
            "memory": resource.RLIMIT_AS,
            "file": resource.RLIMIT_FSIZE,
            "processes": resource.RLIMIT_NPROC,
            "files": resource.RLIMIT_NOFILE,
        }[name]
        hard = resource.getrlimit(kind)[1]
        value = value if hard == resource.RLIM_INFINITY else min(value, hard)
        resource.setrlimit(kind, (value, value))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _load(file: str, rules: Rules) -> tuple[ModuleType | None, dict[str, Any]]:
    """The student's module, and what there is to say about it."""
    sys.meta_path.insert(0, ImportBlocker(rules))
    try:
        module, reading = load(file, rules)
    except BaseException as error:
        return None, {"failures": {"": _not_loaded(error, file)}, "remarks": [], "calls": {}}
    said = {"failures": reading.failures, "remarks": reading.remarks, "calls": reading.calls}
    return module, said


def _not_loaded(error: BaseException, file: str) -> Failure:
    return replace(failure(error, file), kind="not loaded")


if __name__ == "__main__":
    main(int(sys.argv[1]), json.loads(sys.argv[2]), json.loads(sys.argv[3]))
