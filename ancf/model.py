r"""A scene as arrays: rods, the effects it lists, supports, scales; residual and tangent of the whole system.

Equilibrium at load factor l is g(q) = Q_int(q) - l Q_ext(q) = 0 on the motions that the supports allow (paper
eq. 37, where the sign of Q_p is misprinted). Q_int is of the rods and of what is passive, as springs are.

Everything that is compared with a tolerance is dimensionless: unknowns by `unit` (a length L for positions,
L^(1 - order) for derivatives), energies by E I / L, hence forces by E I / L^2 and moments by E I / L.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from copy import copy
from functools import cached_property
from itertools import groupby
from operator import attrgetter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.band import BandCholesky, BandPattern, Factors
from ancf.counters import Counters
from ancf.effect_assembly import EffectAssembly, add_blocks, load_effects
from ancf.effects import Effect, blocks_of
from ancf.finite_difference import difference_tangent
from ancf.linear_system import LinearSystem
from ancf.residual import Residual
from ancf.rod_model import RodModel, make_rod_model
from ancf.scene import Scene
from ancf.section_law import QuadratureSection
from ancf.supports import NodeSupport

if TYPE_CHECKING:
    from scipy import sparse

    from ancf.constraints import Constraints
    from ancf.scene_plane import Plane

Floats = NDArray[np.float64]

# E I/L^2 (moments: E I/L) by which the first step of a prescribed motion may load a joint; a straight rod
# clamped at both ends buckles at 39.5.
FIRST_FORCE = 5.0


class Model:
    """All arrays of a scene. Kernels trust them; validation happened when the scene was read.

    plane : the plane to which motions are confined (planar_model.py); None: none
    eased : whether Newton may make its last steps with the factors at hand (reductions.py)
    """

    plane: Plane | None = None
    eased: bool = False

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.rods: list[RodModel] = []
        first_dof = 0
        for rod in scene.rods:
            model = make_rod_model(scene, rod, first_dof)
            self.rods.append(model)
            first_dof += model.size
        self.motions = first_dof
        self.constraints = self._constraints_of(scene)
        self.n = first_dof if self.constraints is None else self.constraints.end
        self.effects = load_effects(scene, self.rods)
        self.supports: list[NodeSupport] = [s for rod in self.rods for s in rod.node_supports()]
        self.counters = Counters()

    def _constraints_of(self, scene: Scene) -> Constraints | None:
        if not scene.constrained:
            return None
        from ancf.constraints import Constraints

        return Constraints(scene, self.rods, self.motions)

    @cached_property
    def q0(self) -> Floats:
        """Reference coordinates (n,), positions relative to each rod's base."""
        parts = [model.q0.ravel() for model in self.rods]
        return np.concatenate([*parts, np.zeros(self.n - self.motions)])

    @cached_property
    def unit(self) -> Floats:
        """Unit of each unknown (n,): L^(1 - order of the derivative)."""
        parts = []
        for model in self.rods:
            per_node = [model.rod.length ** (1 - sum(order)) for order in model.element.vectors]
            parts.append(np.tile(np.repeat(per_node, 3), len(model.q0)))
        if self.constraints is not None:
            parts.append(self.constraints.unit)
        return np.concatenate(parts)

    @cached_property
    def force_unit(self) -> Floats:
        """Unit of each generalised force (n,): E I / L divided by the unit of the unknown."""
        energy = [np.full(m.size, m.bending_stiffness / m.rod.length) for m in self.rods]
        if self.constraints is not None:
            energy += [np.full(one.conditions, one.energy) for one in self.constraints.models]
        return np.concatenate(energy) / self.unit

    def largest_motion(self, dq: Floats) -> float:
        """Largest dimensionless component of a displacement (n,); multipliers are no motion."""
        return float(np.max(np.abs(dq / self.unit)[: self.motions], initial=0.0))

    @property
    def longest_step(self) -> float:
        """Largest step of the load factor that prescribed motions allow; inf without one."""
        return np.inf if self.constraints is None else self.constraints.longest_step

    def longest_change(self, q: Floats, rate: Floats) -> float:
        """Largest step of a parameter by which prescribed motions change the forces of joints mildly.

        A straight rod that is brought together by a share (R/L)^2 of its length has buckled already: there
        the motion says nothing, and the force does. A step may double it, or bring FIRST_FORCE.

        Parameters
        ----------
        q, rate : (n,) where it starts, and the change of q with the parameter
        """
        if self.longest_step == np.inf:
            return np.inf
        force, change = (np.max(np.abs(v / self.unit)[self.motions :]) for v in (q, rate))
        return float(max(force, FIRST_FORCE) / change) if change > 0.0 else np.inf

    @cached_property
    def settling(self) -> list[Effect]:
        """Effects that hold something fixed in a Newton run, such as contact (settling.py)."""
        return [effect for effect in self.effects if effect.settles]

    def search(self, q: Floats) -> None:
        """Look at q (n,) for the pairs of the Newton run that begins there."""
        for effect in self.settling:
            effect.search(q)

    def augment(self, q: Floats) -> bool:
        """Move what contact holds fixed in a Newton run; whether there was anything to move."""
        moved = [effect.augment(q) for effect in self.settling]
        return any(moved)

    def release(self) -> None:
        """Forget what augmentation has found."""
        for effect in self.settling:
            effect.release()

    @property
    def path_dependent(self) -> bool:
        """Whether an effect depends on the way of load steps."""
        return any(effect.path_dependent for effect in self.effects)

    def commit(self, q: Floats) -> None:
        """Begin the next load step at the accepted equilibrium q (n,)."""
        for effect in self.settling:
            effect.commit(q)

    def restart(self) -> None:
        """Go back to the beginning of a load step that has failed."""
        for effect in self.settling:
            effect.restart()

    def room(self, q: Floats, q_new: Floats) -> float:
        """Share of the way from q to q_new (n,) in which no point can go through an obstacle."""
        return min((effect.room(q, q_new) for effect in self.settling), default=np.inf)

    def is_known(self, q: Floats) -> bool:
        """Whether every effect can tell the state q (n,) from others."""
        return all(effect.is_known(q) for effect in self.effects)

    @property
    def unknowns(self) -> int:
        """Number of unknowns that the supports leave."""
        return self.n - sum(s.rows.shape[0] for s in self.supports)

    # A load may overflow; the solver reports it as not_finite.
    @np.errstate(over="ignore", invalid="ignore", divide="ignore")
    def residual(self, q: Floats, load_factor: float = 1.0) -> Residual:
        """Generalised forces at q (n,); prescribed motions are as far as at the load factor.

        Not finite where a section has collapsed to a line, whose rotation is undefined.
        """
        try:
            return self._residual(q, load_factor)
        except np.linalg.LinAlgError:
            return Residual(np.full(self.n, np.nan), np.full(self.n, np.nan))

    def _residual(self, q: Floats, load_factor: float) -> Residual:
        Q_int, Q_ext = np.zeros(self.n), np.zeros(self.n)
        with self.counters.effect("elastic"):
            for rod in self.rods:
                add_blocks(Q_int, rod.dofs, rod.elastic.force(rod.element_vectors(q)))
        self._effect_sums.forces(Q_int, Q_ext, q)
        self._add_constraints(Q_int, Q_ext, q, load_factor)
        return Residual(Q_int, Q_ext)

    def _add_constraints(self, Q_int: Floats, Q_ext: Floats, q: Floats, load_factor: float) -> list[Floats]:
        """Add the constraints, linear in the load factor about this one; entries of their tangents.

        So Q_ext is -dg/dl of the whole system also where a motion is prescribed.
        """
        tangents = []
        models = [] if self.constraints is None else self.constraints.models
        for name, group in groupby(models, key=attrgetter("name")):
            with self.counters.effect(name):
                for one in group:
                    terms = one.terms(q[one.dofs], load_factor)
                    np.add.at(Q_int, one.dofs, terms.g - load_factor * terms.rate)
                    np.subtract.at(Q_ext, one.dofs, terms.rate)
                    tangents.append(terms.tangent)
        return tangents

    def residual_and_tangent(
        self, q: Floats, load_factor: float, q_previous: Floats | None = None
    ) -> tuple[Residual, Floats]:
        """Generalised forces and the tangent dg/dq in flat band storage, supports not yet applied.

        The entries of constraints and coupled effects follow the band (coupled_system.py).

        `q_previous` switches on the mixed-integration-point tangent (energy.py).
        """
        return self.assembled(self.elastic_terms(q, q_previous), q, load_factor)

    def elastic_terms(self, q: Floats, q_previous: Floats | None = None) -> Iterator[tuple[Floats, Floats]]:
        """Elastic force (..., m, nodal, 3) and tangent (..., m, nd, nd) at q (..., n), piece by piece.

        With leading axes for many states at once (the analytic tangent only).
        """
        differences = self.scene.solver.tangent == "finite-difference"
        with self.counters.effect("elastic"):
            for rod in self.rods:
                e = rod.element_vectors(q)
                e_previous = None if q_previous is None else rod.element_vectors(q_previous)
                for run, elastic in rod.pieces:
                    here = e[..., run, :, :]
                    if differences:
                        unit = blocks_of(self.unit, rod.dofs[run])
                        yield elastic.force(here), difference_tangent(elastic.force, here, unit)
                    else:
                        before = None if e_previous is None else e_previous[..., run, :, :]
                        yield elastic.force_and_tangent(here, before)

    def assembled(
        self, elastic: Iterable[tuple[Floats, Floats]], q: Floats, load_factor: float
    ) -> tuple[Residual, Floats]:
        """`residual_and_tangent` of one state q (n,) from its elastic terms."""
        Q_int, Q_ext = np.zeros(self.n), np.zeros(self.n)
        flat = np.zeros(self.pattern.entries)
        for (dofs, begin, places), (Q_e, K_e) in zip(self._piece_slots, elastic, strict=True):
            add_blocks(Q_int, dofs, Q_e)
            entries = np.bincount(places, K_e.ravel())
            flat[begin : begin + len(entries)] += entries
        coupled = self._effect_sums.terms(Q_int, Q_ext, flat, q, load_factor)
        blocks = self._add_constraints(Q_int, Q_ext, q, load_factor) + coupled
        if blocks:
            flat = np.concatenate([flat, *blocks])
        return Residual(Q_int, Q_ext), flat

    def under(self, scene: Scene) -> Model:
        """The model of a scene that differs in the values of its loads only; all other arrays are shared."""
        # Made once, shared by all copies.
        _ = (self.system, self._piece_slots, self._effect_sums, self.force_unit, self.q0)
        model = copy(self)
        model.scene = scene
        model.effects = load_effects(scene, self.rods)
        model.constraints = model._constraints_of(scene)
        model._effect_sums = self._effect_sums.of(model.effects)
        vars(model).pop("conservative", None)  # by the values
        for made in ("settling", "system") if self.settling else ():  # their state belongs to one model
            vars(model).pop(made, None)
        return model

    def potential(self, q: Floats, load_factor: float = 1.0) -> float | None:
        """Total potential energy [J]; None when a load has none."""
        V = self._effect_sums.potential(q, load_factor)
        if V is None:
            return None
        return V + sum(rod.elastic.energy(rod.element_vectors(q)) for rod in self.rods)

    @cached_property
    def conservative(self) -> bool:
        """Whether all that acts has a potential: the tangent is symmetric, and stability is a minimum.

        By the values of the loads: a moment of value zero does not count.
        """
        constraints = [] if self.constraints is None else self.constraints.models
        held = all(one.conservative for one in constraints)
        return held and self._effect_sums.potential(self.q0, 0.0) is not None

    def is_minimum(self, q: Floats, load_factor: float, factors: Factors, flat: Floats) -> bool:
        """Whether an equilibrium q (n,) is a minimum of the potential, by its tangent and factors."""
        return isinstance(factors, BandCholesky) or self.system.is_positive_definite(flat)

    def determinant_sign(self, q: Floats, load_factor: float, factors: Factors) -> int:
        """Sign of the determinant of the tangent at an equilibrium q (n,), by its factors."""
        return factors.determinant_sign

    def admissible(self, q: Floats) -> Floats:
        """The coordinates (n,) nearest to q that the supports allow: a start may come from anywhere."""
        return self.q0 + self.system.project(q - self.q0)

    def inside_out(self, q: Floats) -> bool:
        """Whether q (n,) has a section point with det F <= 0 where its law is not defined there (rubber)."""
        return any(
            not np.min(law.smallest_volume(rod.generalised(q))) > 0.0 for rod, law in self._laws_of_volume
        )

    @cached_property
    def _laws_of_volume(self) -> list[tuple[RodModel, QuadratureSection]]:
        """Rods with a law that is not defined for det F <= 0 somewhere."""
        laws = [(rod, rod.elastic.section) for rod in self.rods]
        return [(rod, law) for rod, law in laws if isinstance(law, QuadratureSection)]

    @cached_property
    def pattern(self) -> BandPattern:
        """Band of the tangent: the unknowns of one element couple, nothing else."""
        return BandPattern(self.motions, max(rod.dofs.shape[1] for rod in self.rods) - 1)

    @cached_property
    def _piece_slots(self) -> list[tuple[NDArray[np.intp], int, NDArray[np.intp]]]:
        """Unknowns of each piece of the rods, where it begins in the band, the places of its blocks there."""
        found = []
        for rod in self.rods:
            for run, _ in rod.pieces:
                dofs = rod.dofs[run]
                places = self.pattern.block_slots(dofs).ravel()
                found.append((dofs, int(places.min()), places - places.min()))
        return found

    @cached_property
    def _effect_sums(self) -> EffectAssembly:
        differences = self.scene.solver.tangent == "finite-difference"
        return EffectAssembly(self.effects, self.pattern, self.unit, differences, self.counters)

    @cached_property
    def system(self) -> LinearSystem:
        """Supports, scales, factorisation and solution of the tangent."""
        arguments = (self.pattern, self.supports, self.unit, self.force_unit, self.counters)
        coupled = [effect for effect in self.effects if effect.coupled]
        if self.constraints is None and not coupled:
            return LinearSystem(*arguments)
        from ancf.coupled_system import CoupledSystem

        return CoupledSystem(*arguments, self.constraints, coupled)

    def supported_tangent(self, q: Floats, load_factor: float) -> sparse.csr_array:
        """Tangent B_2^T K B_2 on the free unknowns [SI], for inspection (paper eq. 10, 38)."""
        from scipy import sparse  # a quarter of a second, for inspection only

        _, flat = self.residual_and_tangent(q, load_factor)
        if type(self.system) is not LinearSystem:
            from ancf.coupled_system import CoupledSystem

            assert isinstance(self.system, CoupledSystem)
            return (self.boundary_matrix().T @ self.system.unsupported(flat) @ self.boundary_matrix()).tocsr()
        b, n = self.pattern.b, self.n
        bands = self.pattern.banded(flat)[b:]
        full = sparse.dia_array((bands, np.arange(b, -b - 1, -1)), shape=(n, n)).tocsr()
        return (self.boundary_matrix().T @ full @ self.boundary_matrix()).tocsr()

    def connectivity_matrix(self, rod: int, element: int) -> sparse.csr_array:
        """B_1 (unknowns of the element, n) of paper eq. 10: e = B_1 q."""
        from scipy import sparse

        dofs = self.rods[rod].dofs[element]
        shape = (len(dofs), self.n)
        return sparse.csr_array((np.ones(len(dofs)), (np.arange(len(dofs)), dofs)), shape=shape)

    def boundary_matrix(self) -> sparse.csr_array:
        """B_2 (n, free unknowns) of paper eq. 10: dq = B_2 dp, orthonormal columns."""
        return self._boundary_matrix

    @cached_property
    def _boundary_matrix(self) -> sparse.csr_array:
        from scipy import sparse

        free = np.ones(self.n, dtype=bool)
        for s in self.supports:
            free[s.dofs] = False
        rows, columns, values = [np.flatnonzero(free)], [np.arange(free.sum())], [np.ones(free.sum())]
        places = rows.copy()  # of the columns among the unknowns: a support has its at its first one
        for s in self.supports:
            i, j = np.nonzero(s.basis)
            rows.append(s.dofs[i])
            columns.append(sum(map(len, places)) + j)
            values.append(s.basis[i, j])
            places.append(np.full(s.basis.shape[1], s.dofs[0]))
        order = np.argsort(np.concatenate(places), kind="stable")
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        entries = np.concatenate(values), (np.concatenate(rows), rank[np.concatenate(columns)])
        return sparse.csr_array(entries, shape=(self.n, len(order)))
