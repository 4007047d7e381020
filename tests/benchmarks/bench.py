"""Time, memory and results of the package and of others that do the same: `make bench`.

    python tests/benchmarks/bench.py [--quick] [--rounds N] [--results FOLDER] [--task TASK]

With --task and --results only this task's rows are written anew.

Each library works in a process of its own on the same mesh, the Stanford bunny
subdivided twice (a torus of that size where `make data` was not run). The
libraries take turns, round by round, so that a busy machine slows them all; a
figure is the median of the rounds. First it is checked that the answers agree
where the algorithms are the same. Then `filtering.py` measures every filter,
and `scaling.py` meshes of five sizes. The tables are printed and written as CSV
files, from which the report takes its own.

bench.csv has a row for each task and contender:

    vertices, faces   of the mesh (task "flow": the bunny itself, not subdivided)
    task              weights; step (one averaging step in one call); steps (each of twenty
                      in one call); both again "in order": vertices numbered so that neighbours
                      are near in memory, as `mesh.reorder` does; implicit; flow (three
                      weights, twenty steps, SNR at each)
    contender         which library, ours first
    rounds            how often it was measured: slow contenders less often than others
    seconds           median of the rounds; task "steps": divided by twenty
    fastest_round     the same, the least of the rounds
    times_ours        seconds over those of the first contender of the task
    peak_bytes        most memory held at any time beyond that before, in a run of its own
    difference        from our answer: the largest one over our largest entry
    agrees            True or False: whether that is small enough; "not the same" where the
                      algorithm is another one
    times_copy        step and steps: seconds over the time that copying as many bytes takes
                      as one step must read and write; copies take their turn in each round

filters.csv has a row for each filter, and for auto, the front's own choice: seconds with default
parameters, median of rounds, plain_seconds, the same on NumPy and SciPy alone, and peak_bytes.
learned.csv has the learned filter by size: faces, microseconds and peak_bytes for each of them.
starting.csv has the seconds of a new process: Python alone, NumPy and SciPy imported, README's
first example, nothing compiled before.
files.csv has a row for each format: seconds to read a mesh, to read all that the file holds, to
write the mesh, and to write it like the file; in memory.
scaling.csv has a row for each size: vertices, faces, nanoseconds per vertex of each part
(edges, cotangent, averaging, step, whole_flow) and peak_bytes_per_vertex, the most memory
that the whole flow holds. sweeping.csv: see sweeping.py. machine.csv says what was measured on.
"""

import argparse
import importlib.util
import multiprocessing
import tempfile
from pathlib import Path

import files
import filtering
import measuring
import numpy as np
import scaling
import starting
import sweeping
from contenders import CONTENDERS, STEPS, known

from meshfair.mesh import reorder

RESULTS = Path(__file__).resolve().parents[2] / "report" / "results"
IN_ORDER = " in order"
STEP_TASKS = ["step", "steps", "step" + IN_ORDER, "steps" + IN_ORDER]
ROUNDS = {
    "weights": 9,
    **dict(zip(STEP_TASKS, (9, 5, 9, 5), strict=True)),
    "implicit": 3,
    "flow": 5,
}
COPY = "copy"  # a process that copies memory
COPIED = "copy GB/s"
# A contender that has taken so many seconds is not measured again.
ENOUGH = 20

# What the package promises (two cores, 556,051 vertices): ours, how many times as fast, theirs.
PROMISES = [
    ("weights", "ours, edges known", 5, "libigl"),
    ("weights", "ours, from nothing", 3, "libigl"),
    *(
        (task, "ours", wanted, theirs)
        for task in STEP_TASKS
        for theirs, wanted in {"Open3D": 10, "PyVista": 10, "PyMeshLab": 7, "trimesh": 2.5}.items()
    ),
    ("step", "ours", 1.6, "SciPy product"),
    ("implicit", "ours", 4, "SciPy CG, diagonal"),
    ("implicit", "ours", 4, "PyAMG"),
    ("implicit", "ours", 4, "cholespy"),
]
# At most so many times as long as copying the bytes that a step must move.
TIMES_COPY = 2


def serve(pipe):
    """Do what is asked, in a process with one library: the other side of `Process`."""
    k, runs, loaded = None, {}, None
    for question, *details in iter(pipe.recv, None):
        try:
            if question == "mesh":
                if details != loaded:
                    with np.load(*details) as mesh:
                        k, runs, loaded = known(mesh["V"], mesh["F"]), {}, details
                answer = True
            elif question == "prepare":
                contender = next(c for c in CONTENDERS if [c.task, c.name] == details)
                run = runs[tuple(details)] = contender.prepare(k)
                answer = contender.answer(k, run())  # the first run compiles and fills caches
            elif question == "copy":
                answer = measuring.copy_bandwidth(*details)
            else:
                # Memory apart from time: what comes fresh from the system costs time.
                measure = measuring.timed if question == "time" else measuring.peak_memory
                answer, result = measure(runs[tuple(details)])
                del result
        except Exception as error:  # a peer's fault is a line in the table
            answer = error
        pipe.send(answer)


class Process:
    """A process for one library, that answers questions about a mesh."""

    def __init__(self):
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=serve, args=(other,), daemon=True)
        self.process.start()
        other.close()

    def ask(self, *question):
        """Send a question and wait for the answer; raise what went wrong there."""
        self.pipe.send(question)
        answer = self.pipe.recv()
        if isinstance(answer, Exception):
            raise answer
        return answer

    def close(self):
        """Let the process end."""
        self.pipe.send(None)
        self.process.join()


def compare(task, mesh, rounds, processes, copied):
    """Measure the contenders of one task, in turns; return a row for each, ours first.

    In each round memory is copied too: the bandwidths are appended to ``copied``.
    """
    answers, figures = {}, {}
    asked = task.removesuffix(IN_ORDER)
    contenders = [c for c in CONTENDERS if c.task == asked and c.library in processes]
    for c in list(contenders):
        try:
            processes[c.library].ask("mesh", mesh)
            answers[c.name] = processes[c.library].ask("prepare", asked, c.name)
        except Exception as error:
            print(f"  {c.name} failed: {type(error).__name__}: {error}")
            contenders.remove(c)
    figures = {c.name: [] for c in contenders}
    for _ in range(rounds):
        copied.append(processes[COPY].ask("copy"))
        for c in contenders:
            if sum(figures[c.name]) < ENOUGH:
                figures[c.name].append(processes[c.library].ask("time", c.task, c.name))

    repeats = STEPS if asked == "steps" else 1
    ours = contenders[0].name
    fastest = measuring.median(figures[ours])
    rows = []
    for c in contenders:
        seconds = np.array(figures[c.name])
        difference = np.nan if c.within is None else _difference(answers[c.name], answers[ours])
        rows.append(
            {
                "task": task,
                "contender": c.name,
                "rounds": len(seconds),
                "seconds": np.median(seconds) / repeats,
                "fastest_round": seconds.min() / repeats,
                "times_ours": np.median(seconds) / fastest,
                "peak_bytes": processes[c.library].ask("memory", c.task, c.name),
                "difference": difference,
                "agrees": "not the same" if c.within is None else str(difference <= c.within),
            }
        )
    return rows


def in_order(mesh, folder):
    """The same mesh, vertices numbered breadth-first, in a file of its own."""
    with np.load(mesh) as arrays:
        V, F, _ = reorder(arrays["V"], arrays["F"])
    file = Path(folder) / "in_order.npz"
    np.savez(file, V=V, F=F)
    return file


def _installed(library):
    return importlib.util.find_spec(library) is not None


def _difference(X, Y):
    return float(np.abs(X - Y).max() / np.abs(Y).max())


def bytes_to_move(mesh):
    """The least that one averaging step must read and write: A, V, the mask of fixed ones, V+."""
    with np.load(mesh) as arrays:
        k = known(arrays["V"], arrays["F"])
    n = len(k.V)
    return k.A.data.nbytes + 4 * (k.A.nnz + n) + 2 * k.V.nbytes + n


def check_machine(results, tasks):
    """Refuse to write some tasks beside others that another machine has measured."""
    if results is not None and tasks:
        there = {row["what"]: row["value"] for row in measuring.read(results / "machine.csv")}
        for what, value in measuring.machine():
            if there.get(what, value) != value:
                raise SystemExit(
                    f"the figures in {results} were measured with {what} {there[what]}, and "
                    f"here it is {value}: measure all tasks, or give another folder as --results"
                )


def show(rows, n):
    """Print the rows of one task."""
    for row in rows:
        print(
            f"  {row['contender']:26s} {1e3 * row['seconds']:10.2f} ms"
            f"  x {row['times_ours']:6.2f}  {row['peak_bytes'] / n:8.0f} bytes/vertex"
            f"  {row['agrees']}"
        )


def judge(rows):
    """Print how far each promise is kept."""
    seconds = {(row["task"], row["contender"]): row["seconds"] for row in rows}
    for task, ours, wanted, theirs in PROMISES:
        if (task, theirs) in seconds:
            found = seconds[task, theirs] / seconds[task, ours]
            verdict = "kept" if found >= wanted else "NOT KEPT"
            print(f"  {task}: {theirs} / {ours}: {found:.1f} times, wanted {wanted}: {verdict}")
    for row in rows:
        if row["contender"] == "ours" and row["task"] in STEP_TASKS:
            times = row["times_copy"]
            verdict = "kept" if times <= TIMES_COPY else "NOT KEPT"
            print(
                f"  {row['task']}: {times:.1f} times as long as copying its bytes, "
                f"wanted {TIMES_COPY}: {verdict}"
            )


def main(arguments=None):
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="small meshes, one round: a trial")
    parser.add_argument("--rounds", type=int, help="rounds of each task (default: by task)")
    parser.add_argument("--results", type=Path, help="folder of the CSV files")
    parser.add_argument(
        "--task",
        choices=[*ROUNDS, "filters"],
        action="append",
        help="only this, which can be repeated; written only with --results, beside what is there",
    )
    options = parser.parse_args(arguments)
    results = options.results or (None if options.task else RESULTS)
    check_machine(results, options.task)
    tables, rows = {}, []
    with tempfile.TemporaryDirectory() as folder:
        meshes = scaling.meshes(folder, quick=options.quick)
        mesh, n, m = meshes[0 if options.quick else scaling.MAIN]
        print(f"{n:,} vertices, {m:,} faces")
        libraries = dict.fromkeys(c.library for c in CONTENDERS)  # in their order
        for library in (x for x in libraries if not _installed(x)):
            print(f"{library} is not installed, and left out")
        processes = {x: Process() for x in libraries if _installed(x)} | {COPY: Process()}
        bytes_of_step, bandwidths = bytes_to_move(mesh), []
        mesh_of = {"flow": meshes[0][0]}
        mesh_of |= dict.fromkeys((x for x in ROUNDS if IN_ORDER in x), in_order(mesh, folder))
        for task in (x for x in ROUNDS if x in (options.task or ROUNDS)):
            rounds = 1 if options.quick else options.rounds or ROUNDS[task]
            size = meshes[0][1:] if task == "flow" else (n, m)
            copied = []
            of_task = compare(task, mesh_of.get(task, mesh), rounds, processes, copied)
            bandwidths += copied
            bandwidth = measuring.median(copied)
            print(f"{task} (memory copied at {bandwidth / 1e9:.1f} GB/s)")
            show(of_task, size[0])
            for row in of_task:
                times_copy = row["seconds"] * bandwidth / bytes_of_step
                row["times_copy"] = times_copy if task in STEP_TASKS else np.nan
                rows.append({"vertices": size[0], "faces": size[1], **row})
        for process in processes.values():
            process.close()
        judge(rows)
        if rows:
            tables["bench.csv"] = rows
        rounds = 1 if options.quick else options.rounds or 3
        if "filters" in (options.task or ["filters"]):
            tables["filters.csv"] = filtering.table(rounds, options.quick)
            tables["learned.csv"] = filtering.by_size(meshes[: scaling.MAIN + 1])
        if not options.task:
            tables["starting.csv"] = starting.table(1 if options.quick else 9)
            tables["files.csv"] = files.table(meshes[0][0], rounds)
            tables["scaling.csv"] = scaling.table(meshes, rounds)
            tables["sweeping.csv"] = sweeping.table(options.quick)
            facts = [*measuring.machine(), (COPIED, f"{measuring.median(bandwidths) / 1e9:.1f}")]
            tables["machine.csv"] = [{"what": key, "value": x} for key, x in facts]
    if results is not None:
        results.mkdir(parents=True, exist_ok=True)
        if options.task and rows:
            there = measuring.read(results / "bench.csv")
            together = [*rows, *(row for row in there if row["task"] not in options.task)]
            tables["bench.csv"] = sorted(together, key=lambda row: list(ROUNDS).index(row["task"]))
        for name, table in tables.items():
            measuring.write(results / name, table)


if __name__ == "__main__":
    main()
