"""The process in which a student's code runs: loads the file, answers calls.

Started by ``isolation`` with words in JSON: channel, limits, compiled.
Only requests come in and values go out; no right answer is ever here.
"""

import contextlib
import copy
import json
import os
import resource
import shutil
import socket
import sys
from dataclasses import replace
from types import ModuleType
from typing import Any

import scipy.sparse.linalg  # noqa: F401  here once, so that no student's time limit pays for it
from numpy.random import default_rng

from meshfair_grading import protocol
from meshfair_grading.answers import Answer, Failure, Seeded, ask, failure
from meshfair_grading.arguments import borrow
from meshfair_grading.loading import load
from meshfair_grading.rules import ImportBlocker, Rules


def main(words: dict[str, Any]) -> None:
    """Answer calls until the channel is closed.

    Parameters
    ----------
    words : dict
        channel: file descriptor of the socket to the teacher's process. limits: cpu in seconds,
        memory and file in bytes, processes, files. compiled: a folder of what numba has
        compiled, or None.
    """
    channel = socket.socket(fileno=words["channel"])
    if words["compiled"]:
        if words["keep_compiled"]:
            os.environ["NUMBA_CACHE_DIR"] = words["compiled"]
        else:  # numba wants to write to it
            shutil.copytree(words["compiled"], os.environ["NUMBA_CACHE_DIR"])
    _limit(words["limits"])
    with contextlib.suppress(EOFError):
        _answer(channel)
    # Whatever the code has left running ends now, and not when it likes to.
    sys.stdout.flush()
    os._exit(0)


def _answer(channel: socket.socket) -> None:
    protocol.send(channel, {})
    request = protocol.receive(channel)
    file = request["load"]
    rules = Rules(*(tuple(request[key]) for key in ("allowed", "forbidden", "blocked")))
    module, said = _load(file, rules)
    protocol.send(channel, said)
    while True:
        request = protocol.receive(channel)
        given = borrow(channel, request["arguments"])
        before = [copy.deepcopy(argument) for argument in given]
        given = [default_rng(a.seed) if isinstance(a, Seeded) else a for a in given]
        function = getattr(module, request["call"], None)
        if callable(function):
            answer = ask(function, before, file, given)
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
    main(json.loads(sys.argv[1]))
