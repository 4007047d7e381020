"""Flows as far as they are computed: where they begin, and the mesh after each iteration."""

from __future__ import annotations

from collections.abc import Sequence

from scipy.sparse import csr_array

from meshfair.checks import Floats, Integers
from meshfair.operators import averaging
from meshfair.viewer import coloring
from meshfair.weights import BY_NAME


class Start:
    """Where flows begin: a noisy mesh, and its operators, each built when first wanted.

    Parameters
    ----------
    V_true, V_noisy : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    """

    def __init__(self, V_true: Floats, V_noisy: Floats, F: Integers) -> None:
        self.V_true, self.V_noisy, self.F = V_true, V_noisy, F
        self._operators: dict[str, csr_array] = {}
        self._quantities: dict[str, coloring.Quantity] = {}
        self._noisy_values: dict[str, Floats] = {}

    def operator(self, name: str) -> csr_array:
        """The averaging operator with weights by name, see `meshfair.weights.BY_NAME`."""
        if name not in self._operators:
            self._operators[name] = averaging(BY_NAME[name](self.V_noisy, self.F))
        return self._operators[name]

    def quantity(self, name: str) -> coloring.Quantity:
        """What meshes are coloured by, see `meshfair.viewer.coloring.COLORINGS`."""
        if name not in self._quantities:
            self._quantities[name] = coloring.COLORINGS[name].of(self.V_true, self.F)
        return self._quantities[name]

    def noisy_values(self, name: str) -> Floats:
        """The values of such a quantity on the noisy mesh."""
        if name not in self._noisy_values:
            self._noisy_values[name] = self.quantity(name)(self.V_noisy)
        return self._noisy_values[name]


class Run:
    """Flows from one start, each with its own weights, as far as they are computed.

    Parameters
    ----------
    start : Start
    names : sequence of str
        The weights.
    tau : float

    Attributes
    ----------
    states : dict of str to list of ndarray
        The mesh after each iteration, by weights.
    curves : dict of str to list of float
        What is measured of it.
    judged : dict of str to list of float
        How good it is, the larger the better.
    """

    def __init__(self, start: Start, names: Sequence[str], tau: float) -> None:
        self.start, self.tau = start, tau
        self.states: dict[str, list[Floats]] = {name: [] for name in names}
        self.curves: dict[str, list[float]] = {name: [] for name in names}
        self.judged: dict[str, list[float]] = {name: [] for name in names}
        self.shown = False

    @property
    def iterations(self) -> int:
        """How many iterations all flows have made; -1 before the first mesh is there."""
        return min(map(len, self.judged.values())) - 1

    def best(self) -> dict[str, int]:
        """The best iteration of each flow, of those that there are."""
        return {
            name: max(range(len(judged)), key=judged.__getitem__)
            for name, judged in self.judged.items()
            if judged
        }

    def best_of_all(self) -> int:
        """The iteration at which that flow is best which comes furthest."""
        return max(self.best().items(), key=lambda item: self.judged[item[0]][item[1]])[1]
