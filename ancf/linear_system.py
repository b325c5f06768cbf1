"""The tangent with its supports and scales: projected, made dimensionless, factorised, solved.

With D = diag(unit) and the projector P of the supports, K dq = f becomes

    (P D_f^-1 K D P + I - P) (D^-1 dq) = P D_f^-1 f,     D_f = diag(force_unit),

of full size and in the same band: held motions keep a 1 on the diagonal.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.band import BandPattern, Factors, cholesky, factorise, is_positive_definite, negative_eigenvalues
from ancf.counters import Counters
from ancf.supports import NodeSupport

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


class LinearSystem:
    """Linear algebra of one model.

    Parameters
    ----------
    pattern : band of the tangent
    supports : conditions on single nodes
    unit, force_unit : (n,) unit of each unknown and of its generalised force [SI]
    symmetric : whether tangents are symmetric and Cholesky is tried before LU
    """

    def __init__(
        self,
        pattern: BandPattern,
        supports: list[NodeSupport],
        unit: Floats,
        force_unit: Floats,
        counters: Counters,
        symmetric: bool = False,
    ) -> None:
        self.pattern = pattern
        self.supports = supports
        self.unit = unit
        self.force_unit = force_unit
        self.counters = counters
        self.symmetric = symmetric

    @cached_property
    def _scale(self) -> Floats:
        """Factor of each band entry that makes the tangent dimensionless, 0 outside the matrix."""
        n = self.pattern.n
        return (self.pattern.of_rows(1.0 / self.force_unit[:n]) * self.unit[:n, None]).ravel()

    @cached_property
    def _rows(self) -> Indices:
        """Row of each band entry; entries outside the matrix are zero and count for the nearest row."""
        b, n = self.pattern.b, self.pattern.n
        return np.clip(np.arange(n)[:, None] + np.arange(-2 * b, b + 1), 0, n - 1).ravel()

    @cached_property
    def _held(self) -> Indices:
        """Unknowns that supports hold as a whole."""
        found = [s.dofs[s.held] for s in self.supports if s.held is not None]
        return np.concatenate(found) if found else np.empty(0, np.intp)

    @cached_property
    def _oblique(self) -> list[NodeSupport]:
        """Supports that hold combinations of unknowns."""
        return [s for s in self.supports if s.held is None]

    @cached_property
    def _supported_scale(self) -> tuple[Floats, Indices]:
        """`_scale`, 0 for rows and columns of unknowns that are held as a whole; their diagonal slots."""
        n, held = self.pattern.n, self._held
        rows, columns = 1.0 / self.force_unit[:n], self.unit[:n].copy()
        rows[held] = columns[held] = 0.0
        return (self.pattern.of_rows(rows) * columns[:, None]).ravel(), self.pattern.slots(held, held)

    @cached_property
    def _support_slots(self) -> list[tuple[Indices, Indices, Indices]]:
        """Per oblique support: slots of its columns, of its rows and of its diagonal block."""
        b, n = self.pattern.b, self.pattern.n
        found = []
        for s in self._oblique:
            near = np.arange(max(s.dofs[-1] - b, 0), min(s.dofs[0] + b, n - 1) + 1)
            columns = self.pattern.slots(near[:, None], s.dofs)
            rows = self.pattern.slots(s.dofs[:, None], near)
            found.append((columns, rows, self.pattern.slots(s.dofs[:, None], s.dofs)))
        return found

    def project(self, vector: Floats) -> Floats:
        """The part of a vector (n,) or (n, k) that the supports leave free."""
        vector = vector.copy()
        vector[self._held] = 0.0
        for s in self._oblique:
            vector[s.dofs] = s.projector @ vector[s.dofs]
        return vector

    def supported(self, flat: Floats) -> Floats:
        """The dimensionless tangent in flat band storage, 1 on the diagonal for what the supports hold."""
        scale, held = self._supported_scale
        flat = flat * scale
        flat[held] = 1.0
        for (columns, rows, diagonal), s in zip(self._support_slots, self._oblique, strict=True):
            flat[columns] = flat[columns] @ s.projector
            flat[rows] = s.projector @ flat[rows]
            flat[diagonal] += np.eye(len(s.dofs)) - s.projector
        return flat

    def factorise(self, flat: Floats) -> Factors:
        """Factors of the dimensionless, supported tangent; raises `SingularMatrixError`."""
        with self.counters.solving():
            supported = self.supported(flat)
            factor = cholesky(self.pattern, supported) if self.symmetric else None
            return factor or factorise(self.pattern, supported)

    def is_positive_definite(self, flat: Floats) -> bool:
        """Whether a symmetric tangent is positive definite on the motions that the supports allow."""
        with self.counters.solving():
            return is_positive_definite(self.pattern, self.supported(flat))

    def negative_eigenvalues(self, flat: Floats) -> int:
        """Number of negative eigenvalues of a symmetric tangent on the motions that the supports allow."""
        return negative_eigenvalues(self.pattern, self.supported(flat))

    def solve(self, lu: Factors, right: Floats) -> Floats:
        """Displacement (n,) or (n, k) in SI for generalised forces `right` of the same shape."""
        with self.counters.solving():
            column = (slice(None),) + (None,) * (right.ndim - 1)
            dq = lu.solve(self.project(right / self.force_unit[column]))
            return self.project(dq * self.unit[column])

    def solve_transposed(self, lu: Factors, goal: Floats) -> Floats:
        """Adjoint (n,) or (n, k) of a linear goal: z with z . f = goal . solve(lu, f) for all forces f."""
        with self.counters.solving():
            column = (slice(None),) + (None,) * (goal.ndim - 1)
            z = lu.solve(self.project(goal) * self.unit[column], transposed=True)
            return self.project(z) / self.force_unit[column]

    def row_sum(self, flat: Floats, q: Floats) -> float:
        """Largest sum_j |K_ij| |q_j| over the equations i, dimensionless: what rounding of q does to them."""
        entries = np.abs(flat * self._scale).reshape(self.pattern.n, -1) * np.abs(q / self.unit)[:, None]
        return float(np.max(np.bincount(self._rows, entries.ravel())))
