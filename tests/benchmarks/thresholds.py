"""From which size on compiled loops repay their loading: what `meshfair._fast` decides by.

    python tests/benchmarks/thresholds.py

Prints what it takes to load numba and the loops, and for meshes of growing size the seconds of
a flow of twenty steps, and of two filters with their default parameters, in NumPy and compiled.
"""

from unittest import mock

import measuring
import numpy as np

from meshfair import _fast, filters, flow, noise, operators, shapes, weights

ROUNDS = 5


def main():
    """Measure and print."""
    loading, _ = measuring.timed(_load)
    print(f"numba and the loops of a flow and a filter: {loading:.2f} s to load")
    for sections, sides in ((60, 24), (100, 40), (160, 64), (220, 100), (320, 150)):
        V, F = shapes.torus(sections=sections, sides=sides)
        V_noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(0))
        tasks = {
            "a flow": lambda V=V, X=V_noisy, F=F: _flow(X, V, F),
            "guided normal": lambda X=V_noisy, F=F: list(filters.guided_normal(X, F)),
            "feature-convinced": lambda X=V_noisy, F=F: list(filters.feature_convinced(X, F)),
        }
        for name, run in tasks.items():
            if name != "a flow" and len(F) > 4 * _fast.FILTER_ROWS:
                continue
            seconds = [_median(run, compiled) for compiled in (False, True)]
            print(
                f"{len(V):6,} vertices, {len(F):6,} faces, {name:18s} NumPy {seconds[0]:.3f} s, "
                f"compiled {seconds[1]:.3f} s, saved {seconds[0] - seconds[1]:.3f} s"
            )


def _load():
    V, F = shapes.icosphere(1)
    with mock.patch.object(_fast, "wanted", return_value=True):
        _flow(V, V + 1, F)
        list(filters.guided_normal(V, F, iterations=1))


def _flow(V_noisy, V, F):
    A = operators.averaging(weights.cotangent(V_noisy, F))
    return flow.snr_curve(V_noisy, V, A, 0.2, 4.0)


def _median(run, compiled):
    with mock.patch.object(_fast, "wanted", return_value=compiled):
        run()
        return measuring.median(measuring.timed(run)[0] for _ in range(ROUNDS))


if __name__ == "__main__":
    main()
