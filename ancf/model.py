r"""A scene as arrays: rods, the effects it lists, supports, scales; residual and tangent of the whole system.

Equilibrium at load factor l is g(q) = Q_elastic(q) - l Q_ext(q) = 0 on the motions that the supports allow
(paper eq. 37, where the sign of Q_p is misprinted).

Everything that is compared with a tolerance is dimensionless: unknowns by `unit` (a length L for positions,
L^(1 - order) for derivatives), energies by E I / L, hence forces by E I / L^2 and moments by E I / L.
"""

from __future__ import annotations

import importlib
import time
from collections import defaultdict
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.band import BandLU, BandPattern, factorise
from ancf.effects import Effect
from ancf.finite_difference import difference_tangent
from ancf.rod_model import RodModel, make_rod_model
from ancf.scene import Scene
from ancf.supports import NodeSupport

if TYPE_CHECKING:
    from scipy import sparse

Floats = NDArray[np.float64]

# Scene field -> module of ancf.effects. A module is imported only if its field is not empty.
EFFECT_MODULES = {"moments": "moment", "forces": "force", "line_loads": "line_load", "gravity": "gravity"}


@dataclass
class Counters:
    """Calls and seconds by effect name, and seconds by phase: what a solution reports about its cost."""

    calls: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    seconds: dict[str, float] = field(default_factory=lambda: defaultdict(float))
    linear_solve: float = 0.0


@dataclass(frozen=True)
class Residual:
    """Internal and external generalised forces (n,) at one configuration; Q_ext at load factor 1."""

    Q_int: Floats
    Q_ext: Floats

    def at(self, load_factor: float) -> Floats:
        """g = Q_int - load_factor Q_ext; at 0 the load does not count, even where it overflows."""
        if load_factor == 0.0:
            return self.Q_int
        return self.Q_int - load_factor * self.Q_ext


class Model:
    """All arrays of a scene. Kernels trust them; validation happened when the scene was read."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.rods: list[RodModel] = []
        first_dof = 0
        for rod in scene.rods:
            model = make_rod_model(scene, rod, first_dof)
            self.rods.append(model)
            first_dof += model.size
        self.n = first_dof
        self.effects: list[Effect] = []
        for attribute, module in EFFECT_MODULES.items():
            if getattr(scene, attribute):
                self.effects += importlib.import_module(f"ancf.effects.{module}").build(scene, self.rods)
        self.supports: list[NodeSupport] = [s for model in self.rods for s in model.node_supports()]
        self.counters = Counters()

    @cached_property
    def q0(self) -> Floats:
        """Reference coordinates (n,), positions relative to each rod's base."""
        return np.concatenate([model.q0.ravel() for model in self.rods])

    @cached_property
    def unit(self) -> Floats:
        """Unit of each unknown (n,): L^(1 - order of the derivative)."""
        parts = []
        for model in self.rods:
            per_node = [model.rod.length ** (1 - sum(order)) for order in model.element.vectors]
            parts.append(np.tile(np.repeat(per_node, 3), len(model.q0)))
        return np.concatenate(parts)

    @cached_property
    def force_unit(self) -> Floats:
        """Unit of each generalised force (n,): E I / L divided by the unit of the unknown."""
        energy = [np.full(m.size, m.bending_stiffness / m.rod.length) for m in self.rods]
        return np.concatenate(energy) / self.unit

    @property
    def unknowns(self) -> int:
        """Number of unknowns that the supports leave."""
        return self.n - sum(s.rows.shape[0] for s in self.supports)

    # --- forces -----------------------------------------------------------------------------------------

    @np.errstate(over="ignore", invalid="ignore")  # a load may overflow; the solver reports it as not_finite
    def residual(self, q: Floats) -> Residual:
        """Generalised forces at q (n,)."""
        Q_int, Q_ext = np.zeros(self.n), np.zeros(self.n)
        for model in self.rods:
            with self._timed("elastic"):
                Q_e = model.elastic.force(_blocks(q, model.dofs))
            _add(Q_int, model.dofs, Q_e)
        for effect in self.effects:
            with self._timed(effect.name):
                Q_e = effect.force(_blocks(q, effect.dofs))
            _add(Q_ext, effect.dofs, Q_e)
        return Residual(Q_int, Q_ext)

    def residual_and_tangent(
        self, q: Floats, load_factor: float, q_previous: Floats | None = None
    ) -> tuple[Residual, Floats]:
        """Generalised forces and the tangent dg/dq in flat band storage, supports not yet applied.

        `q_previous` switches on the mixed-integration-point tangent (energy.py).
        """
        Q_int, Q_ext = np.zeros(self.n), np.zeros(self.n)
        flat = np.zeros(self.pattern.entries)
        differences = self.scene.solver.tangent == "finite-difference"
        for model, slots in zip(self.rods, self._rod_slots, strict=True):
            with self._timed("elastic"):
                e = _blocks(q, model.dofs)
                if differences:
                    Q_e = model.elastic.force(e)
                    K_e = difference_tangent(model.elastic.force, e, _blocks(self.unit, model.dofs))
                else:
                    e_previous = None if q_previous is None else _blocks(q_previous, model.dofs)
                    Q_e, K_e = model.elastic.force_and_tangent(e, e_previous)
                _add(Q_int, model.dofs, Q_e)
                flat += np.bincount(slots.ravel(), K_e.ravel(), minlength=len(flat))
        for effect, slots in zip(self.effects, self._effect_slots, strict=True):
            with self._timed(effect.name):
                e = _blocks(q, effect.dofs)
                Q_e, K_e = effect.force_and_tangent(e)
                if differences and K_e is not None:
                    K_e = difference_tangent(effect.force, e, _blocks(self.unit, effect.dofs))
                _add(Q_ext, effect.dofs, Q_e)
                if K_e is not None:
                    np.subtract.at(flat, slots.ravel(), load_factor * K_e.ravel())
        return Residual(Q_int, Q_ext), flat

    def potential(self, q: Floats, load_factor: float = 1.0) -> float | None:
        """Total potential energy [J]; None when a load has none."""
        total = sum(model.elastic.energy(_blocks(q, model.dofs)) for model in self.rods)
        for effect in self.effects:
            V = effect.potential(_blocks(q, effect.dofs))
            if V is None:
                return None
            total += load_factor * V
        return total

    # --- linear algebra ---------------------------------------------------------------------------------

    @cached_property
    def pattern(self) -> BandPattern:
        """Band of the tangent: the unknowns of one element couple, nothing else."""
        return BandPattern(self.n, max(model.dofs.shape[1] for model in self.rods) - 1)

    @cached_property
    def _rod_slots(self) -> list[NDArray[np.intp]]:
        return [self.pattern.block_slots(model.dofs) for model in self.rods]

    @cached_property
    def _effect_slots(self) -> list[NDArray[np.intp]]:
        return [self.pattern.block_slots(effect.dofs) for effect in self.effects]

    @cached_property
    def _band_scale(self) -> Floats:
        """Factor of each band entry that makes the tangent dimensionless, 0 outside the matrix."""
        b, n = self.pattern.b, self.n
        column = np.arange(n)
        row = column + np.arange(-2 * b, b + 1)[:, None]
        inside = (row >= 0) & (row < n)
        left = np.where(inside, (1.0 / self.force_unit)[np.clip(row, 0, n - 1)], 0.0)
        return (left * self.unit).ravel()

    @cached_property
    def _support_slots(self) -> list[tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp], Floats]]:
        """Per support: slots of its columns, of its rows, of its diagonal block, and its projector."""
        found = []
        for s in self.supports:
            near = np.arange(
                max(s.dofs[0] - self.pattern.b, 0), min(s.dofs[-1] + self.pattern.b, self.n - 1) + 1
            )
            near = near[(near >= s.dofs[-1] - self.pattern.b) & (near <= s.dofs[0] + self.pattern.b)]
            columns = self.pattern.slots(near[:, None], s.dofs)
            rows = self.pattern.slots(s.dofs[:, None], near)
            found.append((columns, rows, self.pattern.slots(s.dofs[:, None], s.dofs), s.projector))
        return found

    def project(self, vector: Floats) -> Floats:
        """The part of a vector (n,) or (n, k) that the supports leave free."""
        vector = vector.copy()
        for s in self.supports:
            vector[s.dofs] = s.projector @ vector[s.dofs]
        return vector

    def factorise(self, flat: Floats) -> BandLU:
        """LU of the dimensionless, supported tangent; raises `SingularMatrixError`."""
        started = time.perf_counter()
        flat = flat * self._band_scale
        for columns, rows, diagonal, P in self._support_slots:
            flat[columns] = flat[columns] @ P
            flat[rows] = P @ flat[rows]
            flat[diagonal] += np.eye(len(P)) - P
        lu = factorise(self.pattern, flat)
        self.counters.linear_solve += time.perf_counter() - started
        return lu

    def row_sum(self, flat: Floats, q: Floats) -> float:
        """Largest sum_j |K_ij| |q_j| over the equations i, dimensionless: what rounding of q can do to the
        residual."""
        b, n = self.pattern.b, self.n
        bands = np.abs(flat * self._band_scale * np.tile(np.abs(q / self.unit), 3 * b + 1)).reshape(-1, n)
        total = np.zeros(n + 3 * b)
        for band, shift in zip(bands[b:], range(-b, b + 1), strict=True):
            total[b + shift : b + shift + n] += band
        return float(np.max(total[b : b + n]))

    def solve_linear(self, lu: BandLU, right: Floats) -> Floats:
        """Displacement (n,) or (n, k) in SI for generalised forces `right` of the same shape."""
        started = time.perf_counter()
        column = (slice(None),) + (None,) * (right.ndim - 1)
        dq = lu.solve(self.project(right / self.force_unit[column]))
        result = self.project(dq * self.unit[column])
        self.counters.linear_solve += time.perf_counter() - started
        return result

    def supported_tangent(self, q: Floats, load_factor: float) -> sparse.csr_array:
        """Tangent B_2^T K B_2 on the free unknowns [SI], for inspection (paper eq. 10, 38)."""
        from scipy import sparse  # a quarter of a second, for inspection only

        _, flat = self.residual_and_tangent(q, load_factor)
        b, n = self.pattern.b, self.n
        bands = flat.reshape(3 * b + 1, n)[b:]
        full = sparse.dia_array((bands, np.arange(b, -2 * b - 1, -1)), shape=(n, n)).tocsr()
        return (self.boundary_matrix().T @ full @ self.boundary_matrix()).tocsr()

    # --- the paper's matrices, for inspection only --------------------------------------------------------

    def connectivity_matrix(self, rod: int, element: int) -> sparse.csr_array:
        """B_1 (unknowns of the element, n) of paper eq. 10: e = B_1 q."""
        from scipy import sparse

        dofs = self.rods[rod].dofs[element]
        shape = (len(dofs), self.n)
        return sparse.csr_array((np.ones(len(dofs)), (np.arange(len(dofs)), dofs)), shape=shape)

    def boundary_matrix(self) -> sparse.csr_array:
        """B_2 (n, free unknowns) of paper eq. 10: dq = B_2 dp, orthonormal columns."""
        from scipy import sparse

        held = np.zeros(self.n, dtype=bool)
        pieces, order = [], []
        for s in self.supports:
            held[s.dofs] = True
        for dof in np.flatnonzero(~held):
            pieces.append(([dof], np.ones((1, 1))))
            order.append(dof)
        for s in self.supports:
            pieces.append((s.dofs, s.basis))
            order.append(s.dofs[0])
        rows, columns, values, count = [], [], [], 0
        for index in np.argsort(order, kind="stable"):
            dofs, basis = pieces[index]
            i, j = np.nonzero(basis)
            rows += list(np.asarray(dofs)[i])
            columns += list(count + j)
            values += list(basis[i, j])
            count += basis.shape[1]
        return sparse.csr_array((values, (rows, columns)), shape=(self.n, count))

    def _timed(self, name: str) -> _Timer:
        return _Timer(self.counters, name)


class _Timer:
    """Counts one call of an effect and its time."""

    def __init__(self, counters: Counters, name: str) -> None:
        self.counters, self.name = counters, name

    def __enter__(self) -> None:
        self.started = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self.counters.calls[self.name] += 1
        self.counters.seconds[self.name] += time.perf_counter() - self.started


def _blocks(q: Floats, dofs: NDArray[np.intp]) -> Floats:
    """Nodal vectors (m, nd / 3, 3) of the blocks."""
    return q[dofs].reshape(len(dofs), -1, 3)


def _add(total: Floats, dofs: NDArray[np.intp], Q: Floats) -> None:
    total += np.bincount(dofs.ravel(), Q.ravel(), minlength=len(total))
