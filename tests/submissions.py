"""A class of submissions to assignment a2, some of them hostile; its marking, measured.

``python tests/submissions.py`` marks a class of 120, 40 of them hostile, two at a time, and says
how long it took, whether everybody got the right mark, and whether anything around has changed.
"""

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

from meshfair_grading.generate import ASSIGNMENTS
from meshfair_grading.isolation import Isolation, Limits
from meshfair_grading.marking import grade
from meshfair_grading.source import Source

SOURCE = Source.read(ASSIGNMENTS / "source" / "a2.py")
RIGHT = SOURCE.solution()

# Each comes after a right solution, whose last function, averaging, has 3 of the 20 points.
# name: (code, points, what the feedback must name)
HOSTILE = {
    "endless_loop": (
        "def averaging(W):\n    while True:\n        pass\n",
        17,
        "ran out of time",
    ),
    "ten_gigabytes": (
        "def averaging(W):\n    return np.ones(10**10 // 8 * 10)\n",
        17,
        "MemoryError",
    ),
    "segmentation_fault": (
        "def averaging(W):\n    __import__('ctypes').string_at(0)\n",
        17,
        "segmentation fault",
    ),
    "forbidden_import": (
        "def averaging(W):\n    import igl\n    return igl.cotmatrix(W)\n",
        17,
        "does not allow the import of igl",
    ),
    "hidden_import": (
        "def averaging(W):\n    return __import__('meshfair.operators').operators.averaging(W)\n",
        17,
        "is not available to submissions",
    ),
    "fork_bomb": (
        "os = __import__('os')\n"
        "def averaging(W):\n    while True:\n        try:\n            os.fork()\n"
        "        except OSError:\n            raise MemoryError from None\n",
        17,
        "`averaging`",
    ),
    "megabytes_of_output": (
        "def averaging(W):\n    for _ in range(100):\n        print('20 of 20 points ' * 100000)\n",
        17,
        "File too large",
    ),
    "big_file": (
        "def averaging(W):\n    with open('big', 'wb') as file:\n"
        "        file.write(bytes(10**9))\n",
        17,
        "OSError",
    ),
    "syntax_error": ("def averaging(W)\n    return W\n", 0, "SyntaxError"),
    "not_utf8": ("# caf\xe9\n", 0, "UnicodeDecodeError"),
    "missing_function": ("del averaging\n", 17, "There is no function `averaging`"),
    "equal_to_everything": (
        "class Equal:\n    shape = (42, 42)\n    def __eq__(self, other):\n        return True\n"
        "    def __array_function__(self, *arguments):\n        return True\n"
        "def averaging(W):\n    return Equal()\n",
        17,
        "no array of numbers",
    ),
    "system_exit": ("raise SystemExit(0)\n", 20, "SystemExit"),
    "exit_zero": (
        "os = __import__('os')\ndef averaging(W):\n    os._exit(0)\n",
        17,
        "ended the process itself (exit code 0)",
    ),
}


# Further kinds: (code, points, what the feedback must name). Where the answer is right all the
# same, it is 20.
RIGHT_ANSWER = "return scipy.sparse.diags_array(1 / W.sum(axis=1)) @ W"
FURTHER = {
    "memory_of_children": (
        "import os, time\n"
        "def averaging(W):\n    for _ in range(8):\n        if os.fork() == 0:\n"
        "            held = bytearray(10**9 // 2)\n"
        "            held[::4096] = b'x' * len(held[::4096])\n            time.sleep(60)\n"
        "    time.sleep(5)\n",
        17, "of memory in all its processes",
    ),
    "many_files": (
        "def averaging(W):\n    for k in range(10**6):\n        open(f'f{k}', 'w').close()\n",
        17, "made more than 2,000 files",
    ),
    "many_threads": (
        "import threading, time\n"
        "def averaging(W):\n    for _ in range(100):\n"
        "        threading.Thread(target=time.sleep, args=(60,)).start()\n",
        17, "thread",
    ),
    "threads_left_over": (
        "import threading, time, scipy.sparse\n"
        "def averaging(W):\n    threading.Thread(target=time.sleep, args=(60,)).start()\n"
        f"    {RIGHT_ANSWER}\n",
        20, "20 of 20",
    ),
    "child_left_over": (
        "import os, time, scipy.sparse\n"
        "def averaging(W):\n    if os.fork() == 0:\n        os.setsid()\n"
        f"        time.sleep(60)\n    {RIGHT_ANSWER}\n",
        20, "20 of 20",
    ),
    "answer_of_a_child": (
        "import os\n"
        "def averaging(W):\n    os.fork()\n    return W\n",
        17, "`averaging`",
    ),
    "other_students": (
        "import glob\n"
        "def averaging(W):\n    return open(glob.glob('/*/a2.py')[1]).read()\n",
        17, "IndexError",
    ),
    "python_changed": (
        "import os\ndef averaging(W):\n    open(os.__file__, 'a').write('#')\n",
        17, "PermissionError",
    ),
    "grader_replaced": (
        "import sys\n"
        "def averaging(W):\n    sys.modules['__main__'].ask = lambda *_: None\n"
        "    sys.modules['meshfair_grading.protocol'].send = lambda *_: None\n    return W\n",
        17, "`averaging`",
    ),
    "numpy_replaced": (
        "def averaging(W):\n    np.abs = np.allclose = lambda *_, **__: True\n    return W\n",
        17, "`averaging`",
    ),
    "channel_closed": (
        "import os\ndef averaging(W):\n    os.closerange(0, 64)\n    return W\n",
        17, "`averaging`",
    ),
    "first_process_killed": (
        "import os, signal\ndef averaging(W):\n    os.kill(1, signal.SIGKILL)\n    os._exit(9)\n",
        17, "`averaging`",
    ),
    "signals_ignored": (
        "import signal\n"
        "def averaging(W):\n    for k in (1, 2, 3, 15):\n        signal.signal(k, signal.SIG_IGN)\n"
        "    while True:\n        pass\n",
        17, "ran out of time",
    ),
    "regular_expression": (
        "import re\ndef averaging(W):\n    return re.match('(a+)+$', 'a' * 60 + 'b')\n",
        17, "ran out of time",
    ),
    "endless_recursion": (
        "def averaging(W):\n    return averaging(W)\n", 17, "RecursionError",
    ),
    "deep_source": (
        "def averaging(W):\n    return eval('(' * 10**6)\n", 17, "`averaging`",
    ),
    "reads_input": ("def averaging(W):\n    return input('marks? ')\n", 17, "EOFError"),
    "interrupts": ("def averaging(W):\n    raise KeyboardInterrupt\n", 17, "KeyboardInterrupt"),
    "exits": ("import sys\ndef averaging(W):\n    sys.exit('20 of 20')\n", 17, "exit code"),
    "terminal_controls": (
        "def averaging(W):\n    print('\\x1b]0;20 of 20\\x07\\u202e\\x9b2J')\n    return W\n",
        17, "`averaging`",
    ),
    "huge_shape": (
        "import scipy.sparse\n"
        "def averaging(W):\n    return scipy.sparse.csr_array((2**31, 2**31))\n",
        17, "`averaging`",
    ),
    "not_finite": ("def averaging(W):\n    return W * np.inf\n", 17, "`averaging`"),
    "odd_array": (
        "class Odd(np.ndarray):\n    def __array_finalize__(self, other):\n"
        "        raise SystemError('odd')\n"
        "def averaging(W):\n    return np.zeros(3).view(Odd)\n",
        17, "`averaging`",
    ),
    "fake_sparse": (
        "class Fake:\n    shape, nnz, format = (42, 42), 0, 'csr'\n"
        "    def __getattr__(self, name):\n        return lambda *_, **__: self\n"
        "def averaging(W):\n    return Fake()\n",
        17, "no array of numbers",
    ),
    "network": (
        "import socket\n"
        "def averaging(W):\n    socket.create_connection(('127.0.0.1', 22), 1)\n",
        17, "ConnectionRefusedError",
    ),
    "null_bytes": ("# \0\n", 0, "null bytes"),
}  # fmt: skip


def build(folder, students):
    """Write a class: hostile students first, then good ones.

    Parameters
    ----------
    folder : Path
    students : int
        How many; at least as many as there are hostile ones.

    Returns
    -------
    dict of str to (float, str)
        What each must get: points, and a phrase of the feedback.
    """
    expected = {}
    hostile = HOSTILE | (FURTHER if students >= len(HOSTILE) + len(FURTHER) else {})
    names = [*hostile, *(f"good_{number:03}" for number in range(students - len(hostile)))]
    for name in names:
        code, points, phrase = hostile.get(name, ("", 20, "20 of 20 points"))
        path = folder / name / "a2.py"
        path.parent.mkdir(parents=True)
        # Latin-1 makes the one file with an accent wrong UTF-8.
        path.write_bytes(f"{RIGHT}\n\n{code}\n# {name}\n".encode("latin-1"))
        expected[name] = float(points), phrase
    return expected


def surroundings(folders):
    """All that a submission could have changed: processes, and files with what is known of them."""
    processes = {
        path.name: (path / "cmdline").read_bytes()
        for path in Path("/proc").glob("[0-9]*")
        if (path / "cmdline").exists()
    }
    files = {}
    for folder in folders:
        for path in [Path(folder), *Path(folder).rglob("*")]:
            about = path.lstat()
            marks = os.listxattr(path, follow_symlinks=False) if hasattr(os, "listxattr") else []
            facts = about.st_mode, about.st_uid, about.st_gid, about.st_mtime_ns, about.st_nlink
            files[path] = (*facts, tuple(marks), path.read_bytes() if path.is_file() else b"")
    return processes, files


def main():
    """Mark a class and measure; compare what is around it before and after."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("students", type=int, nargs="?", default=120)
    with tempfile.TemporaryDirectory() as folder:
        submissions, out = Path(folder) / "submissions", Path(folder) / "grades.csv"
        expected = build(submissions, parser.parse_args().students)
        private = Path(folder) / "private.txt"
        private.write_text("the teacher's own")
        private.chmod(0o600)
        watched = [submissions, private, Path(__file__).parent]
        isolation = Isolation.detect(Limits(call=3.0, total=18.0))
        before = surroundings(watched)
        start = time.perf_counter()
        marks = grade(submissions, SOURCE, out, isolation, seed=7)
        seconds = time.perf_counter() - start
        after = surroundings(watched)
        feedback = {
            name: (Path(folder) / "grades_feedback" / f"{name}.md").read_text(encoding="utf-8")
            for name in expected
        }
    earned = {mark.student: sum(o.earned for o in mark.outcomes) for mark in marks}
    wrong = {name: earned[name] for name, (points, _) in expected.items() if earned[name] != points}
    silent = [name for name, (_, phrase) in expected.items() if phrase not in feedback[name]]
    new = {pid: line for pid, line in after[0].items() if before[0].get(pid) != line}
    left = [line for line in new.values() if b"meshfair_grading" in line]
    changed = [str(path) for path in before[1] if before[1][path] != after[1].get(path)]
    who = "root" if os.geteuid() == 0 else f"user {os.geteuid()}"
    good = sum(name.startswith("good") for name in expected)
    print(
        f"{len(marks)} submissions, {len(marks) - good} of them hostile, as {who}: {seconds:.1f} s"
    )
    print(f"wrong marks: {wrong or 'none'}; reasons not named: {silent or 'none'}")
    print(f"processes left: {left or 'none'}; files changed: {changed or 'none'}")
    return int(bool(wrong or silent or left or changed))


if __name__ == "__main__":
    sys.exit(main())
