"""A multigrid cycle: a cheap, good guess at the solution of a sparse system.

Averaging with neighbours removes the rough part of an error and leaves the
smooth part, so that an iteration that only looks at neighbours gets slower and
slower. The smooth part can be seen on a coarser graph: join each vertex with
its neighbours to an aggregate, add up their equations, and correct there;
and treat the coarser graph in the same way. No meshes are needed for this,
just the matrix (algebraic multigrid by plain aggregation [VMB96]_, Sec. 5).

An aggregate is several edges wide, so all that is rougher must be damped
before and after the correction: by a few steps of Chebyshev's iteration, which
is as quick as any polynomial in A can be on that part of the spectrum [ABHT03]_.

The cycle is symmetric and positive definite, so it preconditions conjugate
gradients; its single precision halves the memory that must be moved, and the
iteration around it works in double precision.

References
----------
.. [VMB96] P. Vanek, J. Mandel, M. Brezina, "Algebraic multigrid by smoothed aggregation
   for second and fourth order elliptic problems", Computing 56, 1996.
.. [ABHT03] M. Adams, M. Brezina, J. Hu, R. Tuminaro, "Parallel multigrid smoothing:
   polynomial versus Gauss-Seidel", Journal of Computational Physics 188, 2003.
"""

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from meshfair._fast.flow import row_product
from meshfair._fast.kernels import BLOCK, compiled, on_all_cores, unsigned

# An aggregate has about ten vertices.
BLOCK_OF_AGGREGATES = BLOCK // 8
# Graphs of this size and below are solved directly.
COARSEST = 300
# Chebyshev's steps before a correction, and after it.
STEPS = 4
# They damp the part [1 / ROUGH, 1] of the spectrum of D^-1 A. With d_i the sum of
# row i's |a_ij|, all of it is in (0, 1] for every positive definite A.
ROUGH = 30


class Multigrid:
    """One V-cycle for a symmetric positive definite matrix, as a preconditioner.

    Parameters
    ----------
    A : csr_array of float64, shape (n, n)
        Symmetric and positive definite, with sorted or unsorted rows.

    Raises
    ------
    RuntimeError
        A is singular (SciPy's error).
    """

    def __init__(self, A):
        A = csr_array(A / np.abs(A.data).max())  # keeps single precision in its range
        self.levels = []
        while A.shape[0] > COARSEST:
            level = _Level(A)
            if level.size == A.shape[0]:  # nothing left to join
                break
            self.levels.append(level)
            A = level.coarser(A)
        self.coarsest = splu(A.tocsc())
        self.steps = list(_chebyshev(STEPS, 1 / ROUGH, 1.0))

    def cycle(self, R):
        """Return about A^-1 R, up to a factor, and the sums of its products with R.

        Parameters
        ----------
        R : ndarray of float32, shape (n, 3)
            Residuals.

        Returns
        -------
        Z : ndarray of float32, shape (n, 3)
            Overwritten by the next call.
        RZ : ndarray of float64, shape (3,)
            sum_i r_i z_i for each column.
        """
        Z = self._cycle(0, R)
        return Z, np.sum(on_all_cores(_products, len(R), R, Z), axis=0)

    def _cycle(self, depth, R):
        if depth == len(self.levels):
            return self.coarsest.solve(R.astype(np.float64)).astype(np.float32)
        level = self.levels[depth]
        n = len(level.weight)
        A = (*unsigned(level.A.indptr, level.A.indices), level.A.data)
        bounds, members, aggregate = unsigned(level.bounds, level.members, level.aggregate)
        Z, Z_other = level.Z
        (_, scale), *steps = self.steps
        on_all_cores(_start, n, scale, level.weight, R, Z_other, Z)
        for step in steps:
            on_all_cores(_smooth, n, *A, level.weight, R, Z, *step, Z_other)
            Z, Z_other = Z_other, Z
        R_coarse = np.empty((level.size, 3), dtype=np.float32)
        on_all_cores(
            _restrict, level.size, *A, bounds, members, R, Z, R_coarse,
            block=BLOCK_OF_AGGREGATES,
        )  # fmt: skip
        Z_coarse = self._cycle(depth + 1, R_coarse)
        on_all_cores(_correct, n, aggregate, Z_coarse, Z)
        for step in self.steps:
            on_all_cores(_smooth, n, *A, level.weight, R, Z, *step, Z_other)
            Z, Z_other = Z_other, Z
        return Z


def _chebyshev(steps, low, high):
    """Factors (momentum, scale) of Chebyshev's steps for a spectrum in [low, high].

    With them z+ = z + momentum (z - z_before) + scale D^-1 (r - A z), see `_smooth`.
    """
    middle, radius = (high + low) / 2, (high - low) / 2
    momentum, rho = 0.0, radius / middle
    scale = 1 / middle
    for _ in range(steps):
        yield np.float32(momentum), np.float32(scale)
        rho_next = 1 / (2 * middle / radius - rho)
        momentum, scale = rho * rho_next, 2 * rho_next / radius
        rho = rho_next


class _Level:
    """A matrix in single precision, the weights 1 / d_i, and its vertices' aggregates."""

    def __init__(self, A):
        n = A.shape[0]
        # (A.astype would sort every row first.)
        self.A = csr_array((A.data.astype(np.float32), A.indices, A.indptr), shape=A.shape)
        self.weight = np.empty(n, dtype=np.float32)
        on_all_cores(_weights, n, A.indptr, A.data, self.weight)
        self.aggregate = np.full(n, -1, dtype=A.indices.dtype)
        self.size = _aggregate(A.indptr, A.indices, self.aggregate)
        self.bounds = np.zeros(self.size + 1, dtype=A.indices.dtype)
        np.cumsum(np.bincount(self.aggregate, minlength=self.size), out=self.bounds[1:])
        self.members = np.empty(n, dtype=A.indices.dtype)
        _group(self.aggregate, self.bounds[:-1].copy(), self.members)
        self.Z = np.empty((2, n, 3), dtype=np.float32)

    def coarser(self, A):
        """The matrix of the aggregates: entries of A added up over both of them."""
        indptr = np.zeros(self.size + 1, dtype=A.indptr.dtype)
        indices, data = np.empty_like(A.indices), np.empty_like(A.data)
        _add_up(
            self.bounds, self.members, self.aggregate, A.indptr, A.indices, A.data,
            np.full((2, self.size), -1), indptr, indices, data,
        )  # fmt: skip
        k = indptr[-1]
        return csr_array((data[:k].copy(), indices[:k].copy(), indptr), shape=(self.size,) * 2)


@compiled
def _weights(first, last, indptr, A, weight):
    for i in range(first, last):
        total = 0.0
        for p in range(indptr[i], indptr[i + 1]):
            total += abs(A[p])
        weight[i] = 1 / total


@compiled
def _aggregate(indptr, indices, aggregate):
    """Join vertices to aggregates, numbered from 0; return how many there are."""
    count = 0
    for i in range(len(aggregate)):  # whole neighbourhoods where nothing is joined yet
        free = True
        for p in range(indptr[i], indptr[i + 1]):
            free = free and aggregate[indices[p]] == -1
        if free:
            for p in range(indptr[i], indptr[i + 1]):
                aggregate[indices[p]] = count
            aggregate[i] = count
            count += 1
    for i in range(len(aggregate)):  # the rest: to a neighbour's aggregate
        if aggregate[i] == -1:
            for p in range(indptr[i], indptr[i + 1]):
                if aggregate[indices[p]] >= 0:
                    aggregate[i] = -2 - aggregate[indices[p]]  # not yet seen by the others
                    break
    for i in range(len(aggregate)):
        aggregate[i] = -2 - aggregate[i] if aggregate[i] < -1 else aggregate[i]
    return count


@compiled
def _group(aggregate, place, members):
    """List the vertices of each aggregate, one aggregate after the other."""
    for i in range(len(aggregate)):
        members[place[aggregate[i]]] = i
        place[aggregate[i]] += 1


@compiled
def _add_up(bounds, members, aggregate, indptr, indices, A, seen, new_indptr, new_indices, new_A):
    """Entry (I, J) is the sum of a_ij over i in aggregate I and j in aggregate J."""
    row_of, place_of = seen[0], seen[1]  # for column J: the last row with it, and where
    k = 0
    for row in range(len(bounds) - 1):
        for q in range(bounds[row], bounds[row + 1]):
            i = members[q]
            for p in range(indptr[i], indptr[i + 1]):
                column = aggregate[indices[p]]
                if row_of[column] != row:
                    row_of[column] = row
                    place_of[column] = k
                    new_indices[k] = column
                    new_A[k] = 0.0
                    k += 1
                new_A[place_of[column]] += A[p]
        new_indptr[row + 1] = k


@compiled
def _start(first, last, scale, weight, R, Z_zero, Z):
    """Zero, and the first smoothing step from there: z = scale d^-1 r."""
    for i in range(first, last):
        for c in range(3):
            Z_zero[i, c] = 0
            Z[i, c] = scale * weight[i] * R[i, c]


@compiled(fused=True)
def _restrict(first, last, indptr, indices, A, bounds, members, R, Z, R_coarse):
    """Add up the residual R - A Z over each aggregate."""
    for row in range(first, last):
        R_coarse[row, 0] = R_coarse[row, 1] = R_coarse[row, 2] = 0
        for q in range(bounds[row], bounds[row + 1]):
            i = members[q]
            x, y, z, _ = row_product(indptr[i], indptr[i + 1], indices, A, Z)
            R_coarse[row, 0] += R[i, 0] - x
            R_coarse[row, 1] += R[i, 1] - y
            R_coarse[row, 2] += R[i, 2] - z


@compiled
def _correct(first, last, aggregate, Z_coarse, Z):
    """Add the aggregates' correction to all their vertices."""
    for i in range(first, last):
        for c in range(3):
            Z[i, c] += Z_coarse[aggregate[i], c]


@compiled(fused=True)
def _smooth(first, last, indptr, indices, A, weight, R, Z, momentum, scale, Z_other):
    """z + momentum (z - z_before) + scale d^-1 (r - A z), in the place of z_before."""
    p = indptr[first]
    for i in range(first, last):
        x, y, z, p = row_product(p, indptr[i + 1], indices, A, Z)
        w = scale * weight[i]
        x = Z[i, 0] + momentum * (Z[i, 0] - Z_other[i, 0]) + w * (R[i, 0] - x)
        y = Z[i, 1] + momentum * (Z[i, 1] - Z_other[i, 1]) + w * (R[i, 1] - y)
        z = Z[i, 2] + momentum * (Z[i, 2] - Z_other[i, 2]) + w * (R[i, 2] - z)
        Z_other[i, 0], Z_other[i, 1], Z_other[i, 2] = x, y, z


@compiled
def _products(first, last, R, Z):
    """The sums r . z of each column, in double precision."""
    rz_x = rz_y = rz_z = 0.0
    for i in range(first, last):
        rz_x += R[i, 0] * Z[i, 0]
        rz_y += R[i, 1] * Z[i, 1]
        rz_z += R[i, 2] * Z[i, 2]
    return rz_x, rz_y, rz_z
