"""The process in which a student's code runs: loads the file, answers calls.

Started by ``isolation`` as ``python -I -m meshfair_grading.child CHANNEL LIMITS USER``.
Only questions come in and values go out; no right answer is ever here.
"""

import importlib
import importlib.util
import json
import os
import resource
import socket
import sys
from pathlib import Path

import scipy.sparse.linalg  # noqa: F401  here once, so that no student's time limit pays for it

from meshfair_grading import landlock, privileges, protocol
from meshfair_grading.answers import Answer, Failure, ask, failure
from meshfair_grading.rules import ImportBlocker, Rules
from meshfair_grading.students import broken_rules

# What Python and its libraries read beside their own files.
SYSTEM = ("/usr", "/lib", "/lib64", "/bin", "/etc/ld.so.cache", "/etc/localtime", "/proc/self")
DEVICES = ("/dev/null", "/dev/zero", "/dev/random", "/dev/urandom")


def main(channel, limits, user):
    """Answer calls until the channel is closed.

    Parameters
    ----------
    channel : int
        File descriptor of the socket to the teacher's process.
    limits : dict of str to int
        cpu in seconds, memory and file in bytes, processes, files.
    user : int or None
        Whom to become.
    """
    channel = socket.socket(fileno=channel)
    confined = landlock.confine(
        [*SYSTEM, sys.prefix, sys.base_prefix, *sys.path, Path(__file__).parents[1]],
        [*DEVICES, os.getcwd()],
    )
    if user is not None:
        privileges.become(user, keep_reading=confined)
    _limit(limits)
    # Walls that hide Python from itself show here, not in a student's marks.
    importlib.import_module("colorsys")
    protocol.send(channel, {"confined": confined})
    order = protocol.receive(channel)
    file = order["load"]
    rules = Rules(*(tuple(order[key]) for key in ("allowed", "forbidden", "refused")))
    module, failures = _load(file, rules)
    protocol.send(channel, failures)
    while True:
        try:
            order = protocol.receive(channel)
        except EOFError:
            return
        function = getattr(module, order["call"], None)
        if callable(function):
            protocol.send(channel, ask(function, order["arguments"], file))
        else:
            protocol.send(channel, Answer(failure=Failure("missing", order["call"])))


def _limit(limits):
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


def _load(file, rules):
    """The student's module, and why functions of it (or "" for all) cannot be asked."""
    try:
        failures = broken_rules(Path(file).read_bytes(), rules)
    except BaseException as error:
        return None, {"": _not_loaded(error, file)}
    if "" in failures:
        return None, failures
    # Out of the cache, so that importing it again meets the refusal.
    for name in [name for name in sys.modules if name.partition(".")[0] == "meshfair"]:
        del sys.modules[name]
    sys.meta_path.insert(0, ImportBlocker(rules))
    spec = importlib.util.spec_from_file_location(Path(file).stem, file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException as error:  # sys.exit() at module level as well
        return None, {"": _not_loaded(error, file)}
    return module, failures


def _not_loaded(error, file):
    failed = failure(error, file)
    return Failure("not loaded", failed.message, failed.line, failed.code)


if __name__ == "__main__":
    main(int(sys.argv[1]), json.loads(sys.argv[2]), json.loads(sys.argv[3]))
