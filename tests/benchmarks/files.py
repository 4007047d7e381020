"""Reading and writing files: of the mesh alone, and with everything else that a file holds."""

import io as streams

import measuring
import numpy as np

from meshfair import io

# The format, and whether it is binary.
KINDS = {
    "OBJ": ("obj", None),
    "OFF": ("off", None),
    "PLY": ("ply", True),
    "PLY, text": ("ply", False),
    "STL": ("stl", True),
    "STL, text": ("stl", False),
}
WANTED = 1.5  # times as long as without attributes


def table(mesh, rounds):
    """Measure the steps in turns; print and return the rows."""
    with np.load(mesh) as arrays:
        V, F = arrays["V"], arrays["F"]
    rows = []
    print("files, seconds: read, with attributes; written, like another file")
    for kind, (format, binary) in KINDS.items():
        steps = _steps(V, F, format, binary)
        seconds = {step: [] for step in steps}
        for _ in range(rounds):
            for step, run in steps.items():
                seconds[step].append(measuring.timed(run)[0])
        row = {"format": kind, "vertices": len(V), "faces": len(F), "rounds": rounds}
        row |= {step: measuring.median(times) for step, times in seconds.items()}
        slower = max(row["read_all"] / row["read"], row["write_like"] / row["write"])
        verdict = "kept" if slower <= WANTED else "NOT KEPT"
        times = "".join(f" {row[step]:9.4f}" for step in steps)
        print(f"  {kind:10s}{times}; at most {slower:.2f} times, wanted {WANTED}: {verdict}")
        rows.append(row)
    return rows


def _steps(V, F, format, binary):
    """What is measured, in memory: a disk would be measured otherwise."""
    file = streams.BytesIO()
    io.write(file, V, F, format=format, binary=binary)
    data = file.getvalue()
    V_read, F_read, attributes = io.read(streams.BytesIO(data), attributes=True, format=format)
    V_moved = V_read + 0.01 * (V_read[:, [1, 2, 0]] - V_read.mean(axis=0))

    def read(**options):
        return io.read(streams.BytesIO(data), format=format, **options)

    def write(**options):
        io.write(streams.BytesIO(), V_moved, F_read, format=format, binary=binary, **options)

    return {
        "read": read,
        "read_all": lambda: read(attributes=True),
        "write": write,
        "write_like": lambda: write(like=attributes),
    }
