"""A class of submissions to assignment a2, some of them hostile; its marking, measured.

``python tests/submissions.py 100`` marks a class of 100 with two at a time, and
says how long it took and whether everybody got the right mark.
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path

from meshfair_grading.generate import ASSIGNMENTS
from meshfair_grading.isolation import Isolation
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
    names = [*HOSTILE, *(f"good_{number:03}" for number in range(students - len(HOSTILE)))]
    for name in names:
        code, points, phrase = HOSTILE.get(name, ("", 20, "20 of 20 points"))
        path = folder / name / "a2.py"
        path.parent.mkdir(parents=True)
        # Latin-1 makes the one file with an accent wrong UTF-8.
        path.write_bytes(f"{RIGHT}\n\n{code}\n# {name}\n".encode("latin-1"))
        expected[name] = float(points), phrase
    return expected


def main():
    """Mark a class and measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("students", type=int, nargs="?", default=100)
    with tempfile.TemporaryDirectory() as folder:
        submissions, out = Path(folder) / "submissions", Path(folder) / "grades.csv"
        expected = build(submissions, parser.parse_args().students)
        start = time.perf_counter()
        marks = grade(submissions, SOURCE, out, Isolation.detect(), seed=7)
        seconds = time.perf_counter() - start
    earned = {mark.student: sum(o.earned for o in mark.outcomes) for mark in marks}
    wrong = {name: earned[name] for name, (points, _) in expected.items() if earned[name] != points}
    print(f"{len(marks)} submissions, {len(HOSTILE)} of them hostile: {seconds:.1f} s")
    print(f"wrong marks: {wrong or 'none'}")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
