"""Every filter with its default parameters: how long it takes on the public noisy Bunny.

Each runs with the compiled loops and without them, on NumPy and SciPy alone, in turns.
"""

import multiprocessing

import measuring
import numpy as np
from contenders import without_loops

from meshfair import datasets, denoising, io, noise, shapes

# Seconds that the package promises on two cores, on the bunny.
PROMISED = {
    "bilateral": 0.3, "sun": 0.4, "bilateral-normal": 0.6, "guided-normal": 4.5, "l0": 50.0,
}  # fmt: skip
# A filter that has taken so many seconds is not measured again.
ENOUGH = 20


def table(rounds, quick=False):
    """Measure each filter in turn; print and return the rows."""
    V, F, on = _mesh(quick)
    print(f"filters, seconds with default parameters on {on}, {len(F):,} faces")
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        pool.apply(_load, (V, F))
        rows = []
        for method in denoising.methods():
            pool.apply(_timed, (method,))  # compiles, and fills caches
            times, plain_times = [], []
            while len(times) < rounds and sum(times) < ENOUGH:
                times.append(pool.apply(_timed, (method,)))
                if sum(plain_times) < ENOUGH:
                    plain_times.append(pool.apply(_timed, (method, True)))
            seconds, plain = measuring.median(times), measuring.median(plain_times)
            row = {"mesh": on, "faces": len(F), "method": method, "rounds": len(times)}
            rows.append(row | {"seconds": seconds, "plain_seconds": plain})
            wanted = PROMISED.get(method)
            if wanted is None or on != "bunny-noisy":
                verdict = ""
            else:
                verdict = f"wanted {wanted}: {'kept' if seconds <= wanted else 'NOT KEPT'}"
            print(f"  {method:20s} {seconds:8.3f} s  plain {plain:8.3f} s  {verdict}")
    return rows


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
