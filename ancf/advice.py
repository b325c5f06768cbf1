r"""Advice on a scene: which effects could be left out, which missing one would matter, and by how much.

The scene is solved once, and again without each effect, beginning at its equilibrium q; the shift is the
influence of the effect, counted in rod lengths at the tip and where it is largest. Where there is no time for
that, or no equilibrium, one Newton step counts,

    dq = -K^-1 g(q),

with residual g and tangent K of the changed scene: the influence to first order. If the scene itself has no
equilibrium the step is made at the reference, where forces meet the stiffness of the unloaded rods.

Weight is the one missing effect that a scene tells enough about, if its materials have a density. Its
direction is not known, so the worst one counts: the largest singular value of three first steps.

An influence below the wanted accuracy is negligible, above it matters. To first order that is said below half
of it and above twice of it; in between one step is too coarse to tell.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.model import Model
from ancf.scene import Gravity, Scene, StabilityOptions
from ancf.scene_effects import EFFECT_MODULES
from ancf.scene_numbers import STANDARD_GRAVITY, rod_numbers
from ancf.solution import Solution, Status
from ancf.stepping import find_equilibrium

Floats = NDArray[np.float64]

ACCURACY = 1e-3  # of the length, where the scene asks for none
SECONDS = 5.0  # what finding the equilibrium may take, and all others as much
SURE = 2.0  # factor within which one Newton step tells a small influence
NEGLIGIBLE, CLOSE, MATTERS, UNKNOWN = "negligible", "close", "matters", "unknown"


@dataclass(frozen=True)
class Influence:
    """What one effect does to the shape, in rod lengths; None where it cannot be estimated."""

    effect: str  # name of its table
    tip: float | None  # shift of the tip of a rod, of the rod where it is largest
    largest: float | None  # shift of a node of the axis
    verdict: str
    first_order: bool = True  # by one Newton step, not by the equilibrium of the changed scene
    note: str = ""


@dataclass(frozen=True)
class Advice:
    """Numbers of a scene and the influence of its effects, and of missing ones, at an accuracy.

    `state` is where they were estimated: "equilibrium" or "reference".
    """

    accuracy: float
    asked: bool  # whether the scene asks for the accuracy
    state: str
    numbers: dict[str, dict[str, float | None]]  # by rod
    listed: list[Influence]
    missing: list[Influence]

    def as_dict(self) -> dict[str, Any]:
        """Plain Python; every number is finite."""
        return {
            "accuracy": self.accuracy,
            "accuracy_source": "solver.accuracy" if self.asked else "default",
            "state": self.state,
            "numbers": self.numbers,
            "listed": [vars(influence) for influence in self.listed],
            "missing": [vars(influence) for influence in self.missing],
        }


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # what is not finite gives no estimate
def advise(scene: Scene, wanted: float | None = None) -> Advice:
    """Advice on a scene.

    Parameters
    ----------
    scene : with a mesh (`Model.scene` of a prepared model)
    wanted : accuracy of the tip, in lengths, that was asked for; `ACCURACY` if None
    """
    from ancf.solver import solve

    # In full: with one effect more or less a scene may reduce to other unknowns.
    options = replace(scene.solver, max_seconds=min(scene.solver.max_seconds, SECONDS), reduction="full")
    # The branch counts here, modes do not.
    buckled = scene.stability is not None and scene.stability.branch == "buckled"
    stability = StabilityOptions(1, "buckled") if buckled else None
    solution = solve(replace(scene, solver=options, stability=stability))
    state = _State.of(solution, time.perf_counter() + SECONDS)
    limit = ACCURACY if wanted is None else wanted
    return Advice(
        accuracy=limit,
        asked=wanted is not None,
        state=state.name,
        numbers={rod.rod.name: rod_numbers(solution, rod, state.known) for rod in solution.model.rods},
        listed=[_listed(state, name, other, limit) for name, other in without_each(state.scene)],
        missing=[] if scene.gravity is not None else [_weight(state, limit)],
    )


def without_each(scene: Scene) -> Iterator[tuple[str, Scene]]:
    """Each listed effect by the name of its table, and the scene without it."""
    absent = {field.name: field.default for field in fields(Scene)}
    for name, module in EFFECT_MODULES.items():
        if getattr(scene, name):
            yield module, replace(scene, **{name: absent[name]})
    for added in scene.added:
        yield added.table, replace(scene, added=tuple(other for other in scene.added if other is not added))


@dataclass(frozen=True)
class _State:
    """Where influences are estimated."""

    name: str
    model: Model
    scene: Scene  # on the mesh of the model, whatever effects it is given
    q: Floats
    load_factor: float  # of the tangent
    deadline: float  # for finding other equilibria

    @classmethod
    def of(cls, solution: Solution, deadline: float) -> _State:
        model = solution.model
        rods = [replace(r.rod, breaks=tuple(r.mesh.breaks / r.rod.length)) for r in model.rods]
        scene = replace(model.scene, rods=tuple(rods))
        if solution.status is Status.CONVERGED:
            return cls("equilibrium", model, scene, solution.q, 1.0, deadline)
        return cls("reference", model, scene, model.q0, 0.0, deadline)

    @property
    def known(self) -> bool:
        return self.name == "equilibrium"

    def neighbour(self, other: Scene) -> Floats | None:
        """Motion (n or less,) to the equilibrium of another scene, None where it is not found in time."""
        left = self.deadline - time.perf_counter()
        if not self.known or left <= 0.0:
            return None
        model = Model(replace(other, solver=replace(other.solver, max_seconds=left)))
        # The tensions of tendons of given length, which it may lack, are the last unknowns.
        start = self.q[: model.n]
        trace = find_equilibrium(model, start)
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

    def shifts(self, dq: Floats) -> tuple[Floats, NDArray[np.intp]]:
        """Shifts (nodes of all rods, 3) in the lengths of their rods, and which nodes are tips."""
        moved = [rod.nodal(dq)[:, 0] / rod.rod.length for rod in self.model.rods]
        return np.concatenate(moved), np.cumsum([len(part) for part in moved]) - 1


def _listed(state: _State, name: str, without: Scene, limit: float) -> Influence:
    """Influence of a listed effect."""
    dq = state.neighbour(without)
    first_order = dq is None
    if dq is None:
        dq = state.first_step(without)
    if dq is None:
        note = "no estimate: nothing holds the structure without it, or its loads are too large"
        return Influence(name, None, None, MATTERS, note=note)
    moved, tips = state.shifts(dq)
    size = np.linalg.norm(moved, axis=1)
    largest = float(size.max())
    return Influence(
        name, float(size[tips].max()), largest, _verdict(largest, limit, first_order), first_order
    )


def _verdict(largest: float, limit: float, first_order: bool) -> str:
    factor = SURE if first_order else 1.0
    return NEGLIGIBLE if largest < limit / factor else MATTERS if largest > limit * factor else CLOSE


def _weight(state: _State, limit: float) -> Influence:
    """Influence of the weight that the scene leaves out, in the worst direction."""
    if any(part.material.density is None for rod in state.scene.rods for part in rod.parts):
        return Influence("gravity", None, None, UNKNOWN, note="a material has no density")
    columns = []
    for direction in np.eye(3):
        dq = state.first_step(replace(state.scene, gravity=Gravity(STANDARD_GRAVITY * direction)))
        if dq is None:
            return Influence("gravity", None, None, UNKNOWN, note="the tangent is singular here")
        moved, tips = state.shifts(dq)
        columns.append(moved)
    worst = np.linalg.norm(np.stack(columns, axis=-1), 2, axis=(1, 2))
    largest = float(worst.max())
    note = f"{STANDARD_GRAVITY:g} m/s2 in the worst direction"
    return Influence("gravity", float(worst[tips].max()), largest, _verdict(largest, limit, True), note=note)
