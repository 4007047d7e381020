"""Every filter with its default parameters, and the front's own choice, on the public noisy Bunny.

Each runs with the compiled loops and without them, on NumPy and SciPy alone, in turns. The learned
filter also runs on meshes of more and more faces.
"""

import multiprocessing

import measuring
import numpy as np
from contenders import without_loops

from meshfair import datasets, denoising, io, noise, shapes

# Seconds that the package promises on two cores, on the bunny.
PROMISED = {
    "bilateral": 0.3, "sun": 0.4, "bilateral-normal": 0.6, "guided-normal": 4.5, "l0": 50.0,
    "learned": 6.0,
}  # fmt: skip
MOST_MEMORY = 1.5e9  # bytes that the package promises on it, for any filter
# A filter that has taken so many seconds is not measured again.
ENOUGH = 20


def table(rounds, quick=False):
    """Measure each filter in turn; print and return the rows."""
    V, F, on = _mesh(quick)
    print(f"filters, seconds with default parameters on {on}, {len(F):,} faces")
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        pool.apply(_load, (V, F))
        rows = []
        for method in [*denoising.methods(), denoising.DEFAULT]:
            pool.apply(_timed, (method,))  # compiles, and fills caches
            peak = pool.apply(_peak_memory, (method,))
            times, plain_times = [], []
            while len(times) < rounds and sum(times) < ENOUGH:
                times.append(pool.apply(_timed, (method,)))
                if sum(plain_times) < ENOUGH:
                    plain_times.append(pool.apply(_timed, (method, True)))
            seconds, plain = measuring.median(times), measuring.median(plain_times)
            row = {"mesh": on, "faces": len(F), "method": method, "rounds": len(times)}
            rows.append(row | {"seconds": seconds, "plain_seconds": plain, "peak_bytes": peak})
            print(
                f"  {method:20s} {seconds:8.3f} s  plain {plain:8.3f} s  {peak / 1e6:6.0f} MB"
                + (_verdict(method, seconds, peak) if on == "bunny-noisy" else "")
            )
    return rows


def by_size(meshes):
    """Run the learned filter once on each mesh, with noise; print and return the rows."""
    print("the learned filter by size, microseconds and bytes a face")
    rows = []
    for file, _, m in meshes:
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            seconds, peak = pool.apply(_learned, (file,))
        rows.append({"faces": m, "face_us": 1e6 * seconds / m, "peak_bytes_per_face": peak / m})
        print("  " + "  ".join(f"{key} {value:,.6g}" for key, value in rows[-1].items()))
    return rows


def _verdict(method, seconds, peak):
    """Whether what is promised is kept."""
    verdict = "" if peak <= MOST_MEMORY else f"  wanted {MOST_MEMORY / 1e6:.0f} MB: NOT KEPT"
    if method in PROMISED:
        wanted = PROMISED[method]
        verdict += f"  wanted {wanted} s: {'kept' if seconds <= wanted else 'NOT KEPT'}"
    return verdict


def _mesh(quick):
    if quick:
        V, F = shapes.box(segments=4)
        return noise.along_normals(V, F, 0.2, np.random.default_rng(0)), F, "box"
    try:
        return *io.read(datasets.fetch("bunny-noisy")), "bunny-noisy"
    except datasets.DownloadError as error:
        print(f"without the bunny, on a torus: {error}")
        V, F = shapes.torus(sections=292, sides=120)
        return noise.along_normals(V, F, 0.2, np.random.default_rng(0)), F, "torus"


# In the process that measures: the mesh, sent once.
_LOADED = {}


def _load(V, F):
    _LOADED["mesh"] = V, F


def _timed(method, plain=False):
    def run():
        return denoising.denoise(*_LOADED["mesh"], method)

    seconds, _ = measuring.timed(without_loops(run) if plain else run)
    return seconds


def _peak_memory(method):
    return measuring.peak_memory(lambda: denoising.denoise(*_LOADED["mesh"], method))[0]


def _learned(file):
    """Seconds and memory of the learned filter on a file's mesh."""
    rng, small = np.random.default_rng(0), shapes.icosphere(4)
    denoising.denoise(*small, "learned")  # compiles
    with np.load(file) as arrays:
        V, F = arrays["V"], arrays["F"]
    V = noise.along_normals(V, F, 0.2, rng)
    peak, (seconds, _) = measuring.peak_memory(
        lambda: measuring.timed(lambda: denoising.denoise(V, F, "learned"))
    )
    return seconds, peak
