r"""The linear system of rods with constraints, or effects that couple more than an element: a sparse one.

The multipliers of joints and of tendons of given length (constraints.py) are among the unknowns:

    [ K   C^T ] [ dq      ]
    [ C    0  ] [ dlambda ]        K with the second derivatives of the conditions,

projected onto the supports and made dimensionless as without them (linear_system.py), then factorised with
pivoting (SuperLU). The tangent is kept flat: the band of the rods, then the entries of each constraint, then
the blocks of each coupled effect.

An equilibrium is stable if K is positive on the motions that C leaves. With C of full rank, which the scene's
check sees to, K has there as many negative eigenvalues as the whole matrix less one for each condition. They
are counted without eigenvalues of the whole: the unknowns that no block touches form band matrices, whose
inertia adds to that of the small dense complement of the others (Haynsworth 1968, Linear Algebra Appl. 1).

A rod closed to a ring has neutral motions: a round one may turn about its tangent at the joint, every section
against it, and strains no more. The matrix is singular there to rounding, at a regular equilibrium. Such a
motion v is found by inverse iteration; loads that do no work on it do not move the rod along it, and it
counts as neither sign.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from ancf.band import (
    BandPattern,
    Factors,
    SingularMatrixError,
    factorise,
    named_failure,
    negative_eigenvalues,
)
from ancf.constraints import Constraints
from ancf.counters import Counters
from ancf.effects import Effect
from ancf.linear_system import LinearSystem
from ancf.supports import NodeSupport

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


# An eigenvalue below so many eps |A| is rounding of zero.
NEUTRAL = 30.0
# A load works on a neutral motion by no more than this share of it, or by this much of E I/L^2: rounding.
NO_WORK, NO_FORCE = 1e-7, 1e-8


@dataclass(frozen=True)
class Neutral:
    """Null vectors (n,), dimensionless: from the right, its motion alone (of length 1), and from the left."""

    vector: Floats
    motion: Floats
    left: Floats


@dataclass(frozen=True)
class SparseLU:
    """LU factors of the sparse matrix; see `band.Factors`."""

    lu: Any  # scipy.sparse.linalg.SuperLU
    conditions: int
    neutral: Neutral | None = None

    def solve(self, right: Floats, transposed: bool = False) -> Floats:
        """See `band.Factors`."""
        if transposed:
            z = self.lu.solve(right, trans="T")
            if self.neutral is not None:  # the solution without its part along the left null vector
                left = self.neutral.left / np.linalg.norm(self.neutral.left)
                z = z - np.multiply.outer(left, left @ z)
            return z
        x = self.lu.solve(right)
        if self.neutral is not None:
            noise = np.maximum(NO_WORK * np.linalg.norm(right, axis=0), NO_FORCE)
            idle = np.abs(self.neutral.left @ right) <= noise
            x = x - np.multiply.outer(self.neutral.vector, np.where(idle, self.neutral.motion @ x, 0.0))
        return x

    @property
    def log_determinant(self) -> float:
        """See `band.Factors`."""
        return float(np.sum(np.log(np.abs(self.lu.U.diagonal()))))

    @property
    def determinant_sign(self) -> int:
        """Sign of the determinant on the motions that the constraints leave.

        Each condition brings a negative eigenvalue of its own, which is not counted.
        """
        negative = np.count_nonzero(self.lu.U.diagonal() < 0.0)
        odd = negative + _odd(self.lu.perm_r) + _odd(self.lu.perm_c) + self.conditions
        return 1 if odd % 2 == 0 else -1


def _neutral(A: Any, lu: Any, motions: int) -> Neutral | None:
    """Neutral motion of a matrix that is singular to rounding, else None.

    With forces in units of the largest entry the axial compliance of a rod is no small eigenvalue.
    """
    largest = float(np.max(np.abs(A.data)))
    scale = np.ones(A.shape[0])
    scale[motions:] = np.sqrt(largest)
    found = []
    for side in ("N", "T"):
        v = np.random.default_rng(0).standard_normal(A.shape[0])
        for _ in range(2):
            v = lu.solve(v / np.linalg.norm(v) / scale, trans=side) / scale
        if not np.linalg.norm(v) * NEUTRAL * float(np.finfo(float).eps) * largest > 1.0:
            return None
        found.append(scale * v / np.linalg.norm(v[:motions]))
    motion = np.where(np.arange(len(scale)) < motions, found[0], 0.0)
    return Neutral(found[0], motion, found[1])


def _odd(permutation: Indices) -> int:
    """0 for an even permutation, 1 for an odd one: its size less the number of its cycles."""
    seen, cycles = np.zeros(len(permutation), dtype=bool), 0
    for start in range(len(permutation)):
        if not seen[start]:
            cycles += 1
            while not seen[start]:
                seen[start] = True
                start = permutation[start]
    return (len(permutation) - cycles) % 2


class CoupledSystem(LinearSystem):
    """Linear algebra of one model with constraints or coupled effects; the unknowns of the rods come first.

    Parameters
    ----------
    pattern : band of the rods' tangent
    unit, force_unit : (n,) of the rods' unknowns and the multipliers
    constraints : None where there is none
    effects : those that are `coupled`
    """

    def __init__(
        self,
        pattern: BandPattern,
        supports: list[NodeSupport],
        unit: Floats,
        force_unit: Floats,
        counters: Counters,
        constraints: Constraints | None,
        effects: list[Effect],
    ) -> None:
        super().__init__(pattern, supports, unit, force_unit, counters)
        self.constraints = constraints
        self.effects = effects
        self.conditions = len(unit) - pattern.n

    @cached_property
    def _band(self) -> tuple[Indices, Indices, Indices]:
        """Row, column and slot of each entry of the band inside the matrix."""
        b, n = self.pattern.b, self.pattern.n
        row = np.arange(n) + np.arange(-b, b + 1)[:, None]
        column = np.broadcast_to(np.arange(n), row.shape)
        inside = (row >= 0) & (row < n)
        return row[inside], column[inside], self.pattern.slots(row[inside], column[inside])

    def _blocks(self) -> tuple[Indices, Indices]:
        """Row and column of each entry of the blocks, which an effect may have changed."""
        constraints = [] if self.constraints is None else self.constraints.models
        dofs = [effect.dofs for effect in self.effects]
        rows = [one.rows for one in constraints] + [np.repeat(d, d.shape[1], axis=1).ravel() for d in dofs]
        columns = [one.columns for one in constraints] + [np.tile(d, d.shape[1]).ravel() for d in dofs]
        return np.concatenate(rows), np.concatenate(columns)

    @cached_property
    def _projector(self) -> sparse.csr_array:
        """Projector (n, n) of the supports."""
        n = len(self.unit)
        rows, columns, values = [np.arange(n)], [np.arange(n)], [np.ones(n)]
        for s in self.supports:
            rows.append(np.repeat(s.dofs, len(s.dofs)))
            columns.append(np.tile(s.dofs, len(s.dofs)))
            values.append((s.projector - np.eye(len(s.dofs))).ravel())
        entries = tuple(np.concatenate(part) for part in (values, rows, columns))
        return sparse.coo_array((entries[0], entries[1:]), shape=(n, n)).tocsr()

    def unsupported(self, flat: Floats) -> sparse.csr_array:
        """The tangent [SI], supports not applied."""
        row, column, slot = self._band
        rows, columns = (np.concatenate(pair) for pair in zip((row, column), self._blocks(), strict=True))
        values = np.concatenate([flat[slot], flat[self.pattern.entries :]])
        n = len(self.unit)
        return sparse.coo_array((values, (rows, columns)), shape=(n, n)).tocsr()

    def matrix(self, flat: Floats) -> sparse.csc_array:
        """The dimensionless tangent, 1 on the diagonal for what the supports hold."""
        row, column, slot = self._band
        n, P = len(self.unit), self._projector
        rods = self.supported(flat[: self.pattern.entries])[slot]
        rows, columns = self._blocks()
        scaled = flat[self.pattern.entries :] * self.unit[columns] / self.force_unit[rows]
        blocks = P @ sparse.coo_array((scaled, (rows, columns)), shape=(n, n)).tocsr() @ P
        return (sparse.coo_array((rods, (row, column)), shape=(n, n)).tocsr() + blocks).tocsc()

    def factorise(self, flat: Floats) -> Factors:
        """LU of the dimensionless, supported tangent; raises `SingularMatrixError`."""
        with self.counters.solving():
            A = self.matrix(flat)
            try:
                lu: Any = splu(A)
            except RuntimeError as error:
                raise SingularMatrixError(str(error)) from error
            return SparseLU(lu, self.conditions, _neutral(A, lu, self.pattern.n))

    def is_positive_definite(self, flat: Floats) -> bool:
        """Whether a symmetric tangent is positive on the motions that supports and constraints allow."""
        with self.counters.solving():
            return self.negative_eigenvalues(flat) == 0

    @named_failure()
    def negative_eigenvalues(self, flat: Floats) -> int:
        """Number of negative eigenvalues on the motions that supports and constraints allow."""
        # Rods of different stiffness have different units: one for all makes the matrix symmetric.
        energy = self.unit * self.force_unit
        scale: Any = sparse.diags_array(energy / np.max(energy))
        A: Any = scale @ self.matrix(flat)
        n = self.pattern.n
        # By the columns of the conditions: a slack tendon acts on nothing, and its row is none of theirs.
        A = sparse.block_array([[A[:n, :n], A[:n, n:]], [A[:n, n:].T, A[n:, n:]]])
        A = (0.5 * (A + A.T)).tocsr()
        conditions = self.conditions
        neutral = _neutral(A, splu(A.tocsc()), self.pattern.n)
        if neutral is not None:  # hold it
            v, conditions = neutral.motion[:, None], conditions + 1
            A = sparse.block_array([[A, v], [v.T, None]]).tocsr()
        held = np.zeros(A.shape[0], dtype=bool)
        if self.constraints is not None:
            held[self.constraints.held_dofs] = True
        for effect in self.effects:
            held[effect.dofs] = True
        held[self.pattern.n :] = True
        inner, outer = np.flatnonzero(~held), np.flatnonzero(held)
        complement = A[outer][:, outer].toarray()
        count = 0
        if len(inner):
            # Taking unknowns out of a band leaves one.
            pattern = BandPattern(len(inner), min(self.pattern.b, len(inner) - 1))
            band = np.zeros(pattern.entries)
            block = A[inner][:, inner].tocoo()
            band[pattern.slots(*block.coords)] = block.data
            count = negative_eigenvalues(pattern, band)
            coupling = A[inner][:, outer].toarray()
            complement -= coupling.T @ factorise(pattern, band).solve(coupling)
        f = np.linalg.eigvalsh(0.5 * (complement + complement.T))
        return count + int(np.count_nonzero(f < 0.0)) - conditions

    def row_sum(self, flat: Floats, q: Floats) -> float:
        """Largest sum_j |K_ij| |q_j| over the equations i, dimensionless: what rounding of q does to them."""
        size = abs(self.unsupported(flat)) @ np.abs(q)
        return float(np.max(size / self.force_unit))
