"""Examples: a shape, noise of a random kind and size on it, and what a stage is then given."""

import numpy as np
import torch
from kernels import Moved
from network import tensors

from meshfair import _fast, mesh, noise, operators, weights
from meshfair.checks import Floats, Integers
from meshfair.filters.face_network import Rings
from meshfair.filters.guided_normal import Patches
from meshfair.filters.neighbourhoods import face_rings
from meshfair.filters.normal_bank import filtered_normals, surfaces
from meshfair.mesh.geometry import incidence

_fast.FILTER_ROWS = 0  # the loops are loaded anyway


def correlated(V: Floats, F: Integers, sigma: float, rng: np.random.Generator) -> Floats:
    """Noise as a scanner leaves it: white noise along the normals, smoothed over the surface."""
    A = operators.averaging(weights.combinatorial(F, len(V)))
    height = rng.standard_normal((len(V), 1))
    for _ in range(rng.integers(1, 5)):
        height = (height + A @ height) / 2
    height = height / height.std() + rng.uniform(0, 0.7) * rng.standard_normal((len(V), 1))
    height *= sigma * mesh.mean_edge_length(V, F) / height.std()
    return V + height * mesh.vertex_normals(V, F)


def shared(V: Floats, F: Integers, sigma: float, rng: np.random.Generator) -> Floats:
    """Noise that neighbours share, over a width of its own."""
    return noise.correlated(V, F, sigma, rng, int(rng.integers(1, 9)))


def uniform(V: Floats, F: Integers, sigma: float, rng: np.random.Generator) -> Floats:
    """Uniform noise of this standard deviation, and of mean zero."""
    amplitude = np.sqrt(12) * sigma * mesh.mean_edge_length(V, F)
    return noise.uniform(V, amplitude, rng) - amplitude / 2


def impulsive(V: Floats, F: Integers, sigma: float, rng: np.random.Generator) -> Floats:
    """Noise on a part of the vertices."""
    return noise.impulsive(V, F, sigma, rng.uniform(0.1, 0.6), rng)


KINDS = {
    noise.along_normals: 0.34,
    noise.gaussian: 0.27,
    uniform: 0.07,
    impulsive: 0.12,
    correlated: 0.1,
    shared: 0.1,
}
LARGEST = 0.8  # noise size, in mean edges
CLEAN = 0.05  # share of the examples without noise


def noisy(V: Floats, F: Integers, rng: np.random.Generator) -> Floats:
    """Positions with noise of a random kind and size; sizes from 0.1 to 0.4 are most common."""
    if rng.random() < CLEAN:
        return V
    make = list(KINDS)[rng.choice(len(KINDS), p=list(KINDS.values()))]
    return make(V, F, LARGEST * rng.beta(1.3, 2.2), rng)


class Surface:
    """A shape, and what is found once of its faces."""

    def __init__(self, V: Floats, F: Integers) -> None:
        self.V, self.F = V, F
        self.B = incidence(F, len(V))
        self.patches = Patches(face_rings(self.B))
        self.N = mesh.face_normals(V, F)


class Example:
    """What a stage is given of a noisy surface, and the normals that it should give.

    Parameters
    ----------
    surface : Surface
        The clean one.
    V : ndarray of float64, shape (n, 3)
        Noisy positions, or those that the stage before has left.
    previous : ndarray of float64, shape (m, 2, 3)
        The normals of the noisy mesh, and those that the stage before wanted.
    """

    def __init__(self, surface: Surface, V: Floats, previous: Floats) -> None:
        F, smoothed = surface.F, surfaces(V, surface.F)
        self.mesh = V, F, surface.B
        bank = np.stack([*filtered_normals(V, F, smoothed, surface.patches)], axis=1)
        N, area, C = mesh.face_shapes(V, F)
        smooth = mesh.face_shapes(smoothed[0], F)[2]
        G = np.concatenate([bank, previous], axis=1)
        self.inputs = tensors(G, Rings(surface.patches.rings, C, smooth, area))
        self.wanted = torch.from_numpy(surface.N).float()
        self.noisy = float(np.linalg.norm(N - surface.N, axis=1).mean())

    def errors(self, wanted: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """How far from the true normals those are that a stage wants, and what they lead to.

        Parameters
        ----------
        wanted : tensor, shape (m, 3)
            Unit normals.

        Returns
        -------
        two tensors
            The mean distance of both, that of the normals of the mesh without faces that have
            turned over: these are for the first to mend.
        """
        moved = Moved.apply(wanted, *self.mesh)
        upright = (moved * self.wanted).sum(dim=1).detach() > 0
        apart = [(N - self.wanted).norm(dim=1) for N in (wanted, moved)]
        return apart[0].mean(), (apart[1] * upright).mean()
