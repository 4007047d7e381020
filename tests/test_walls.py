"""Attacks on what TEACHING.md promises of the walls around a submission, as root and as a user."""

import contextlib
import dataclasses
import os
import re
import socket
import stat
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from meshfair_grading import isolation as isolating
from meshfair_grading import walls
from meshfair_grading.isolation import Isolation, Limits, NoWallsError
from meshfair_grading.rules import Rules
from meshfair_grading.students import IsolatedStudent

pytestmark = pytest.mark.slow
USER = 23456  # nobody has this number

# What a submission could try; each function returns what it reached, or raises.
ATTACKS = """
os, socket, time, sys = map(__import__, ("os", "socket", "time", "sys"))

def call(name, *arguments):
    return getattr(os, name)(*arguments)

def change_mode(): os.chmod("TARGET", 0o777)
def change_owner(): os.chown("TARGET", os.getuid(), os.getgid())
def change_times(): os.utime("TARGET", (1, 1))
def set_attribute(): os.setxattr("TARGET", "user.mark", b"20")
def link(): os.link("TARGET", "mine")
def rename(): os.rename("TARGET", "TARGET.old")
def remove(): os.unlink("TARGET")
def cut(): os.truncate("TARGET", 0)
def read(): return len(open("TARGET").read())
def write(): open("TARGET", "a").write("x")
def make_pipe(): os.mkfifo("FOLDER/pipe")
def make_file(): open("FOLDER/file", "w").write("x")
def make_device(): os.mknod("null", 0o600 | 0o020000, os.makedev(1, 3))
def follow(): os.symlink("TARGET", "way"); return len(open("way").read())
def change_null(): os.chmod("/dev/null", 0o600)
def change_core_pattern(): open("/proc/sys/kernel/core_pattern", "w").write("|/box/mine")
def lift_out_of_memory(): open("/proc/self/oom_score_adj", "w").write("-1000")
def change_python(): open(os.__file__, "a").write("#")
def change_numpy(): open(__import__("numpy").__file__, "a").write("#")
def change_root(): open("/mine", "w").write("x")
def fill_devices(): open("/dev/mine", "wb").write(bytes(10**7))
def kill_parent(): os.kill(PARENT, 9)
def trace(): open("/proc/PARENT/mem", "rb").read(1)
def connect(): socket.create_connection(("127.0.0.1", PORT), 2).close()
def connect_by_name():
    with socket.socket(socket.AF_UNIX) as s:
        s.connect("\\0meshfair-MESSAGES")
def name_server(): socket.getaddrinfo("localhost.localdomain", 80)
def new_user():
    if __import__("ctypes").CDLL(None, use_errno=True).unshare(0x10000000):
        raise PermissionError("unshare")
def set_user(): os.setuid(0)
def set_hostname(): socket.sethostname("x" if os.getuid() == 0 else "y")
def message_queue():
    if __import__("ctypes").CDLL(None, use_errno=True).msgget(MESSAGES, 0) < 0:
        raise PermissionError("msgget")
def nice(): os.setpriority(os.PRIO_PROCESS, 0, -20)
def more_memory():
    resource = __import__("resource")
    resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))

def names(folder): return len(os.listdir(folder))
def secrets(): return len([name for name in os.environ if "TOKEN" in name])
def processes(): return len([name for name in os.listdir("/proc") if name.isdigit()])
def at_home(): return len(os.listdir("."))
def write_here(): return open("here", "w").write("x")
def fill_home():
    return sum(open(f"f{k}", "wb").write(bytes(10**6)) for k in range(100))
def fill_memory(): return open("/dev/shm/x", "wb").write(bytes(10**8))

def import_it(name): return len(__import__(name).__name__)
def import_without_finder(name):
    sys.meta_path[:] = [finder for finder in sys.meta_path if "Blocker" not in str(finder)]
    return len(__import__("importlib").import_module(name).__name__)
def search(word):
    found = 0
    for folder, _, files in os.walk("/"):
        if not folder.startswith(("/proc", "/sys", "/usr/share", "/box")):
            found += sum(word in os.path.join(folder, file) for file in files)
    return found
def load_library(name):
    folders = [folder for folder in sys.path if os.path.isdir(folder)]
    return len([1 for folder in folders for f in os.listdir(folder) if name in f])
"""
REFUSED = [
    "change_mode", "change_owner", "change_times", "set_attribute", "link", "rename", "remove",
    "cut", "read", "write", "make_pipe", "make_file", "make_device", "follow", "change_null",
    "change_core_pattern", "lift_out_of_memory", "change_python", "change_numpy", "change_root",
    "fill_devices", "kill_parent", "trace", "connect", "connect_by_name", "name_server", "new_user",
    "set_user", "set_hostname", "message_queue", "nice", "more_memory", "fill_home", "fill_memory",
]  # fmt: skip


@pytest.fixture(scope="module")
def isolation():
    """Walls, with limits that do not let a test wait for long."""
    trouble = walls.trouble()
    if trouble:
        pytest.skip(trouble)
    return Isolation.detect(Limits(call=4.0, total=30.0, file=8_000_000))


@pytest.fixture(scope="module")
def target(tmp_path_factory):
    """A private file of the teacher's, in a folder that everybody may write to."""
    folder = tmp_path_factory.mktemp("theirs")
    folder.chmod(0o777)
    file = folder / "private.txt"
    file.write_text("the teacher's")
    file.chmod(0o600)
    return file


@pytest.fixture(scope="module")
def outside():
    """What can be reached outside: a port, an abstract socket, a message queue."""
    import ctypes

    libc = ctypes.CDLL(None, use_errno=True)
    key = os.getpid()
    queue = libc.msgget(key, 0o1666)
    with socket.create_server(("127.0.0.1", 0)) as server, socket.socket(socket.AF_UNIX) as named:
        named.bind(f"\0meshfair-{key}")
        named.listen()
        yield {"PORT": str(server.getsockname()[1]), "MESSAGES": str(key)}
    libc.msgctl(queue, 0, None)


@pytest.fixture(scope="module")
def attack(isolation, target, outside):
    """One process for all attacks that leave it alive: ``attack(function, *arguments)``."""
    code = ATTACKS.replace("TARGET", str(target)).replace("FOLDER", str(target.parent))
    code = code.replace("PARENT", str(os.getpid()))
    for word, value in outside.items():
        code = code.replace(word, value)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TOKEN_OF_THE_TEACHER", "secret")
        with IsolatedStudent(code.encode(), "a9", Rules(), isolation) as student:
            yield lambda name, *arguments: student._ask(name, arguments)


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(name, attack, target):
    before = target.stat(), target.read_text(), sorted(target.parent.iterdir())
    null = Path("/dev/null").stat().st_mode
    failure = attack(name).failure
    assert failure is not None, "it was possible"
    assert failure.kind == "raised", failure
    assert (target.stat(), target.read_text(), sorted(target.parent.iterdir())) == before
    assert Path("/dev/null").stat().st_mode == null


@pytest.mark.parametrize(
    ("name", "arguments", "value"),
    [
        ("secrets", (), 0),
        ("processes", (), 2),  # the first one, and Python
        ("write_here", (), 1),
        ("search", ("meshfair/weights.py",), 0),
        ("search", ("a2_checks",), 0),
        ("search", ("/igl",), 0),
        ("search", ("trimesh",), 0),
        ("load_library", ("igl",), 0),
    ],
)
def test_what_is_seen(name, arguments, value, attack):
    answer = attack(name, *arguments)
    assert answer.failure is None, answer.failure
    assert answer.value == value


@pytest.mark.parametrize("library", ["meshfair", "igl", "trimesh", "open3d", "numba", "pytest"])
@pytest.mark.parametrize("way", ["import_it", "import_without_finder"])
def test_what_cannot_be_seen_cannot_be_imported(library, way, attack):
    assert "Error" in attack(way, library).failure.message
    assert attack(way, "scipy.sparse.linalg").value > 0


def test_a_refused_import_is_named(isolation):
    code = "def f():\n    return __import__('meshfair.operators')\n"
    with IsolatedStudent(code.encode(), "a9", Rules(), isolation) as student:
        message = student._ask("f", ()).failure.message
    assert "meshfair is not available to submissions of this assignment" in message


def test_an_allowed_library_comes_with_what_it_needs(isolation):
    code = "import matplotlib.pyplot\ndef f():\n    return len(matplotlib.__version__)\n"
    rules = Rules(allowed=("numpy", "scipy", "matplotlib"))
    with IsolatedStudent(code.encode(), "a9", rules, isolation) as student:
        assert student._ask("f", ()).value >= 5


TOGETHER = """
os, time, threading = map(__import__, ("os", "time", "threading"))

def memory():
    for _ in range(6):
        if os.fork() == 0:
            held = bytearray(300_000_000)
            held[::4096] = bytes(len(held[::4096])).replace(bytes(1), b"x")
            time.sleep(60)
    time.sleep(10)

def processes():
    made = 0
    try:
        while True:
            if os.fork() == 0:
                time.sleep(60)
            made += 1
    except OSError:
        raise MemoryError(f"after {made} processes") from None

def threads():
    for _ in range(100):
        threading.Thread(target=time.sleep, args=(60,)).start()
    time.sleep(10)

def files():
    for k in range(10**6):
        open(f"f{k}", "w").close()

def folders():
    for k in range(10**6):
        os.mkdir(f"f{k}")
"""


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("memory", "used more than 1 GB of memory in all its processes"),
        ("processes", r"started more than 32 processes|after [1-3]?\d processes"),
        ("threads", "started more than 32 processes or threads|can't start new thread"),
        ("files", "made more than 2,000 files"),
        ("folders", "made more than 2,000 files"),
    ],
)
def test_what_all_processes_use_together(name, said, isolation):
    limits = dataclasses.replace(isolation.limits, memory=10**9)
    small = dataclasses.replace(isolation, limits=limits)
    with IsolatedStudent(TOGETHER.encode(), "a9", Rules(), small) as student:
        assert re.search(said, student._ask(name, ()).failure.message)
        assert student._ask("missing", ()).failure.kind == "missing"  # of a new process


SURVIVORS = {
    "a session of its own": "os.setsid(); time.sleep(60)",
    "a grandchild": "os.fork() or (os.setsid(), time.sleep(60))",
    "deaf": "[signal.signal(k, signal.SIG_IGN) for k in (1, 2, 15)]; time.sleep(60)",
}


@pytest.mark.parametrize("code", SURVIVORS.values(), ids=SURVIVORS)
@pytest.mark.parametrize("ends", ["a right answer", "the time limit"])
def test_no_process_stays(code, ends, isolation):
    # A limit that no other test has marks the command line.
    limits = dataclasses.replace(isolation.limits, files=61, call=0.7)
    marked = dataclasses.replace(isolation, limits=limits)
    wait = "time.sleep(30)" if ends == "the time limit" else "time.sleep(0.2)"
    source = f"""
os, signal, time, threading = map(__import__, ("os", "signal", "time", "threading"))

def f():
    threading.Thread(target=time.sleep, args=(60,)).start()
    if os.fork() == 0:
        {code}
    {wait}
    return 0
"""
    with IsolatedStudent(source.encode(), "a9", Rules(), marked) as student:
        failure = student._ask("f", ()).failure
        assert (failure is not None) == (ends == "the time limit")
    deadline = time.monotonic() + 5
    while command_lines(b'"files": 61') and time.monotonic() < deadline:
        time.sleep(0.02)
    assert command_lines(b'"files": 61') == []


def command_lines(part):
    """The command lines of all processes with some words in them."""
    lines = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):  # it has just ended
            lines.append(path.read_bytes())
    return [line for line in lines if part in line]


@pytest.mark.parametrize("end", ["return 0", "os._exit(3)", "time.sleep(60)", "os.kill(1, 9)"])
def test_what_was_printed_arrives_however_it_ends(end, isolation):
    source = f"""
os, time = __import__("os"), __import__("time")
print("at the top")

def f():
    print("without a line's end", end="")
    {end}
"""
    quick = dataclasses.replace(isolation, limits=dataclasses.replace(isolation.limits, call=1.0))
    with IsolatedStudent(source.encode(), "a9", Rules(), quick) as student:
        student._ask("f", ())
    assert student.printed == "at the top\nwithout a line's end"


def test_students_do_not_count_each_other(isolation):
    """What one runs leaves the others all of their own processes."""
    code = """
import threading, time
def f():
    made = [threading.Thread(target=time.sleep, args=(2,)) for _ in range(20)]
    [thread.start() for thread in made]
    time.sleep(1)
    return len(made)
"""
    found = []

    def one():
        with IsolatedStudent(code.encode(), "a9", Rules(), isolation) as student:
            found.append(student._ask("f", ()).value)

    both = [threading.Thread(target=one) for _ in range(3)]
    for thread in both:
        thread.start()
    for thread in both:
        thread.join()
    np.testing.assert_array_equal(found, [20, 20, 20])


def test_a_submission_in_any_encoding_arrives_byte_for_byte(isolation):
    source = "# -*- coding: latin-1 -*-\ndef f():\n    return len('caf\xe9')\n".encode("latin-1")
    with IsolatedStudent(source, "a9", Rules(), isolation) as student:
        assert student._ask("f", ()).value == 4


# --- Without walls ---------------------------------------------------------------------


def test_without_bubblewrap_nobody_is_marked_unless_that_is_wanted(monkeypatch):
    monkeypatch.setattr(walls.shutil, "which", lambda name: None)
    with pytest.raises(NoWallsError, match=r"apt install bubblewrap.*--without-walls"):
        Isolation.detect()
    plain = Isolation.detect(Limits(call=2.0, total=10.0), without_walls=True)
    assert not plain.walls
    assert "walls: NONE" in plain.describe()[0]
    code = b"def f():\n    return 7\n\ndef g():\n    return __import__('igl')\n"
    with IsolatedStudent(code, "a9", Rules(), plain) as student:
        assert student._ask("f", ()).value == 7
        assert "igl is not available" in student._ask("g", ()).failure.message


def test_bubblewrap_that_does_not_work_says_why(monkeypatch, tmp_path):
    broken = tmp_path / "bwrap"
    broken.write_text("#!/bin/sh\necho 'No permissions to create new namespace' >&2; exit 1\n")
    broken.chmod(0o755)
    monkeypatch.setattr(walls, "BWRAP", str(broken))
    if sys.platform == "linux":
        assert "No permissions to create new namespace" in walls.trouble()


def test_an_old_kernel_counts_no_processes_by_user(monkeypatch):
    for release, numbers in (("6.1.0-13-amd64", (6, 1)), ("5.4.0", (5, 4)), ("odd", (0, 0))):
        monkeypatch.setattr(isolating.platform, "release", lambda release=release: release)
        assert isolating._release() == numbers


# --- The same as an ordinary user ------------------------------------------------------


def closed_to_others(path):
    """The first folder above a path that only its owner may pass through, or None."""
    above = [*reversed(path.parents), path]
    return next((folder for folder in above if not folder.stat().st_mode & stat.S_IXOTH), None)


def test_all_of_this_as_an_ordinary_user(tmp_path_factory):
    if sys.platform != "linux" or os.geteuid() != 0:
        pytest.skip("this is an ordinary user already")
    if walls.trouble():
        pytest.skip(walls.trouble())
    home = tmp_path_factory.mktemp("home")
    os.chown(home, USER, USER)
    here = Path(__file__)
    # Python and these tests may lie in root's home: there the user gets a view with these alone.
    needed = [Path(sys.base_prefix), Path(sys.prefix), here.parents[1], home]
    needed += [Path(folder).resolve() for folder in sys.path if Path(folder).is_dir()]
    view = [walls.BWRAP, "--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID",
            "--dev-bind", "/", "/"]  # fmt: skip
    closed = {folder for folder in map(closed_to_others, needed) if folder}
    for folder in sorted(closed):
        view += ["--perms", "0755", "--tmpfs", str(folder)]
    for path in needed:
        for folder in reversed(path.parents):
            if any(folder.is_relative_to(other) and folder != other for other in closed):
                view += ["--perms", "0755", "--dir", str(folder)]
        if any(path.is_relative_to(other) for other in closed):
            view += ["--bind", str(path), str(path)]
    environment = {**os.environ, "HOME": str(home), "TMPDIR": str(home)}
    environment = {k: v for k, v in environment.items() if not k.startswith("PYTEST_")}
    run = subprocess.run(
        [*view, "setpriv", f"--reuid={USER}", f"--regid={USER}", "--clear-groups",
         sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:dash", "-n", "0",
         "-k", "not ordinary_user", f"--rootdir={here.parents[1]}", str(here)],
        env=environment, capture_output=True, text=True, cwd=home,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout[-3000:] + run.stderr[-2000:]
    assert "passed" in run.stdout
    assert "skipped" not in run.stdout, run.stdout[-3000:]
