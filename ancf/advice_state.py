r"""Where influences are estimated: at the equilibrium of a scene, by the way to that of a changed one.

The changed scene is solved, beginning at the equilibrium q. Where there is no time for that, or no
equilibrium, one Newton step counts,

    dq = -K^-1 g(q),

with residual g and tangent K of the changed scene: the influence to first order. If the scene itself has no
equilibrium the step is made at the reference, where forces meet the stiffness of the unloaded rods.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.error_estimate import ErrorEstimate, estimate_error
from ancf.influence import CLOSE, UNKNOWN, Influence, verdict_of, worded
from ancf.model import Model
from ancf.newton import newton
from ancf.scene import Scene
from ancf.solution import Solution, Status
from ancf.stepping import DIRECT_ITERATIONS, find_equilibrium

Floats = NDArray[np.float64]

SMALL = 0.03  # rod lengths: below, one Newton step tells the influence within a factor of 2
NEAR = 1e-3  # of the wanted accuracy: how near to equilibrium an error estimate needs to be at least


@dataclass(frozen=True)
class State:
    """An equilibrium, or the reference."""

    solution: Solution
    model: Model
    scene: Scene  # on the mesh of the model, whatever effects it is given
    q: Floats
    load_factor: float  # of the tangent
    limit: float  # wanted accuracy in rod lengths
    deadline: float  # for finding other equilibria

    @classmethod
    def of(cls, solution: Solution, limit: float, deadline: float) -> State:
        """Where a solution ended."""
        model = solution.model
        rods = [replace(r.rod, breaks=tuple(r.mesh.breaks / r.rod.length)) for r in model.rods]
        scene = replace(model.scene, rods=tuple(rods))
        if solution.status is Status.CONVERGED:
            return cls(solution, model, scene, solution.q, 1.0, limit, deadline)
        return cls(solution, model, scene, model.q0, 0.0, limit, deadline)

    @property
    def known(self) -> bool:
        """Whether it is an equilibrium."""
        return self.solution.status is Status.CONVERGED

    @property
    def near(self) -> Scene:
        """The scene, whose path from the reference does not count: equilibria near by are looked for."""
        options = replace(self.scene.solver, method="newton")
        return replace(self.scene, solver=options, stability=None)

    @cached_property
    def errors(self) -> ErrorEstimate | None:
        """Estimated errors of mesh and model; None where they are not known, as with contact."""
        if not self.known or self.scene.contacts or time.perf_counter() > self.deadline:
            return None
        solution = replace(self.solution, scene=self.near, accuracy=None)
        return estimate_error(solution, NEAR * self.limit, self.deadline)

    def neighbour(self, other: Scene, afresh: bool = False) -> Floats | None:
        """Motion (n or less,) to the equilibrium of another scene, None where it is not found in time.

        Searched for from here, or `afresh` from the reference.
        """
        left = self.deadline - time.perf_counter()
        if not self.known or left <= 0.0:
            return None
        model = Model(replace(other, solver=replace(other.solver, max_seconds=left)))
        # The tensions of tendons of given length, which it may lack, are the last unknowns.
        start = self.q[: model.n]
        if self.scene.follows_path and not other.follows_path:
            # From the reference another branch would be found.
            result = newton(model, start, 1.0, DIRECT_ITERATIONS, self.deadline)
            return result.q - start if result.converged else None
        trace = find_equilibrium(model, None if afresh else start)
        return trace.q - start if trace.status is Status.CONVERGED else None

    def first_step(self, other: Scene) -> Floats | None:
        """dq (n or less,) of one Newton step; None where the other scene's tangent is singular, dq overflows,
        or a rod may touch: contact is not linear.
        """
        if other.contacts or self.scene.contacts:
            return None
        model = Model(other)
        q = self.q[: model.n]
        g = model.residual(q).at(1.0) - self.model.residual(self.q).at(1.0)[: model.n]
        try:
            _, flat = model.residual_and_tangent(q, self.load_factor)
            dq = model.system.solve(model.system.factorise(flat), -g)
        except (ArithmeticError, np.linalg.LinAlgError):
            return None
        size = dq / model.unit
        return dq if np.isfinite(size @ size) else None

    def shifts(self, dq: Floats) -> Floats:
        """Shifts (nodes of all rods, 3) in the lengths of their rods."""
        moved = [rod.nodal(dq)[:, 0] / rod.rod.length for rod in self.model.rods]
        return np.concatenate(moved)

    @cached_property
    def tips(self) -> NDArray[np.intp]:
        """Which of the nodes are tips."""
        return np.cumsum([len(rod.q0) for rod in self.model.rods]) - 1

    def influence(
        self, effect: str, other: Scene, negligible: str, matters: str, rough: bool = False, **about: Any
    ) -> Influence:
        """Influence of a change of the scene, with the advice for either verdict.

        rough : whether the change is an estimate itself
        about : further fields of `Influence`
        """
        dq = self.neighbour(other)
        first_order = rough or dq is None
        if dq is None:
            dq = self.first_step(other)
        if dq is None:
            return Influence(effect, None, None, UNKNOWN, advice="no estimate", **about)
        size = np.linalg.norm(self.shifts(dq), axis=1)
        return self.judged(
            effect, float(size[self.tips].max()), float(size.max()), first_order, negligible, matters, **about
        )

    def judged(
        self,
        effect: str,
        tip: float,
        largest: float,
        first_order: bool,
        negligible: str,
        matters: str,
        **about: Any,
    ) -> Influence:
        """Influence of a size that is known."""
        verdict = verdict_of(largest, self.limit, first_order)
        advice = worded(verdict, negligible, matters)
        return Influence(effect, tip, largest, verdict, first_order, advice=advice, **about)

    def of_worst_direction(
        self, effect: str, under: Callable[[Floats], Scene], negligible: str, matters: str, **about: Any
    ) -> Influence:
        """Influence of a load of known size and unknown direction, the worst one.

        To first order that is the largest singular value of three first steps. Where it is not small the
        equilibria under the load both ways along that direction count, with contact those along six.

        under : the scene under the load in a direction (3,) of length 1
        """
        steps = [self.first_step(under(axis)) for axis in np.eye(3)]
        columns = [self.shifts(dq) for dq in steps if dq is not None]
        directions = np.eye(3)
        tip = largest = None
        if len(columns) == 3:
            _, values, right = np.linalg.svd(np.stack(columns, axis=-1))
            worst = values[:, 0]
            tip, largest = float(worst[self.tips].max()), float(worst.max())
            if largest < SMALL:
                return self.judged(effect, tip, largest, True, negligible, matters, **about)
            directions = right[int(np.argmax(worst)), :1]
        found = [self.neighbour(under(sign * axis)) for axis in directions for sign in (1.0, -1.0)]
        sizes = [np.linalg.norm(self.shifts(dq), axis=1) for dq in found if dq is not None]
        if sizes:
            tip = max(float(size[self.tips].max()) for size in sizes)
            largest = max(float(size.max()) for size in sizes)
        if tip is None or largest is None:
            return Influence(effect, None, None, UNKNOWN, advice="no estimate", **about)
        if sizes and len(sizes) < len(found):
            about["note"] = f"{about.get('note', '')}; at least, some directions were not solved"
            if largest < self.limit:
                return Influence(effect, tip, largest, CLOSE, advice="too close to tell", **about)
        return self.judged(effect, tip, largest, not sizes, negligible, matters, **about)
