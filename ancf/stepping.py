"""Load steps: predictor, Newton, growth and cut-back, and a typed reason when no equilibrium is found.

The full load is tried first from the moment predictor, or from the reference when there is none. If that
fails the load grows in steps: each start is extrapolated in local measures (rod_shape.py), a failed step is
cut, quick steps grow. Nothing goes on from a failed step: the path continues from the last equilibrium.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ancf.model import Model
from ancf.newton import Iteration, NewtonResult, Outcome, newton
from ancf.predictor import Path, moment_start
from ancf.solution import Status

Floats = NDArray[np.float64]

DIRECT_ITERATIONS = 25  # for the full load in one step
STEP_ITERATIONS = 10  # in a load step: beyond it a shorter step is cheaper
QUICK_ITERATIONS = 6  # a step that took no more may grow
GROWTH = 2.0
CUT = 0.25
SMALLEST_STEP = 1e-6  # of the full load
FIRST_TURN = (
    1.0  # the linear solution of the first load step may turn or move sections by this (rad, lengths)
)
# dq / d load factor grows like 1 / sqrt(distance) towards a limit point; with steps down to 1e-6 by far
# more than this.
LIMIT_POINT_RATE = 20.0
# Uniaxial Saint Venant-Kirchhoff, P = E (s^3 - s) / 2, carries no more compression below s = 1/sqrt(3) =
# 0.577;
# a rod within 3 % of it when the search ends has met that limit.
UNSTABLE_STRETCH = 0.595


@dataclass
class Trace:
    """What happened on the way: equilibrium reached last, counts, history, and why it stopped."""

    status: Status
    q: Floats
    load_factor: float = 0.0
    residual: float = 0.0
    floor: float = 0.0
    steps: int = 0
    cutbacks: int = 0
    history: list[Iteration] = field(default_factory=list)
    failure: NewtonResult | None = None  # the Newton iteration that ended the search
    tried: float = 0.0  # load factor of that iteration
    rates: list[float] = field(default_factory=list)  # |dq / d load factor| at the equilibria of the walk

    @property
    def iterations(self) -> int:
        """Linear solves in all, failed steps included."""
        return len(self.history)


def find_equilibrium(model: Model, start: Floats | None = None) -> Trace:
    """Equilibrium at the full load, or the last one on the way to it.

    Parameters
    ----------
    start : coordinates (n,) to begin from (a resumed state); Newton tries them before anything else
    """
    options = model.scene.solver
    deadline = time.perf_counter() + options.max_seconds
    trace = Trace(Status.NOT_CONVERGED, model.q0)
    direct = [] if start is None else [start]
    if options.predictor == "auto":
        bent = moment_start(model, 1.0)
        direct.append(model.q0 if bent is None else bent)
    for q in direct:
        result = newton(model, q, 1.0, DIRECT_ITERATIONS)
        trace.history += result.history
        if _accept(model, trace, result, 1.0):
            trace.status = Status.CONVERGED
            return trace
        trace.cutbacks += 1
        if time.perf_counter() > deadline:
            trace.status = Status.OUT_OF_TIME
            return trace
    return _walk(model, trace, deadline)


def _accept(model: Model, trace: Trace, result: NewtonResult, load_factor: float) -> bool:
    """Take over a converged step whose configuration is not turned inside out."""
    if result.converged and inverted_at(model, result.q) is None:
        trace.q, trace.load_factor, trace.residual = result.q, load_factor, result.residual
        trace.floor = result.floor
        trace.steps += 1
        return True
    trace.failure, trace.tried = result, load_factor
    return False


def _walk(model: Model, trace: Trace, deadline: float) -> Trace:
    """Load steps from zero with growth and cut-back."""
    options = model.scene.solver
    path = Path(model, model.q0)
    step = _first_step(model)
    while trace.load_factor < 1.0:
        if trace.steps + trace.cutbacks >= options.max_steps:
            return trace
        if time.perf_counter() > deadline:
            trace.status = Status.OUT_OF_TIME
            return trace
        target = trace.load_factor + step
        if target > 1.0 - 1e-9:
            target = 1.0
        result = newton(model, _start(model, path, trace, target), target, STEP_ITERATIONS)
        trace.history += result.history
        if _accept(model, trace, result, target):
            path.add(target, result.q)
            trace.rates.append(_rate(model, result))
            if len(result.history) <= QUICK_ITERATIONS:
                step *= GROWTH
            continue
        trace.cutbacks += 1
        step = (target - trace.load_factor) * CUT
        if step < SMALLEST_STEP:
            trace.status = _reason(model, trace, result)
            return trace
    trace.status = Status.CONVERGED
    return trace


def _first_step(model: Model) -> float:
    """First load step: the linear solution may turn the sections by about a radian."""
    forces, flat = model.residual_and_tangent(model.q0, 0.0)
    try:
        dq = model.solve_linear(model.factorise(flat), forces.Q_ext)
    except ArithmeticError:
        return 1.0
    largest = float(np.max(np.abs(dq / model.unit), initial=0.0))
    return float(np.clip(FIRST_TURN / largest, SMALLEST_STEP, 1.0)) if largest > 0.0 else 1.0


def _start(model: Model, path: Path, trace: Trace, target: float) -> Floats:
    if len(path.points) > 1:
        return path.extrapolate(target)
    forces, flat = model.residual_and_tangent(trace.q, trace.load_factor)
    try:
        dq = model.solve_linear(model.factorise(flat), -model.project(forces.at(target)))
    except ArithmeticError:
        return trace.q
    return path.from_tangent(dq) if np.isfinite(dq).all() else trace.q


def inverted_at(model: Model, q: Floats) -> tuple[str, int, float] | None:
    """Rod, element and det of the first axial point whose position gradient is not right-handed, or None."""
    for rod in model.rods:
        v = rod.elastic.generalised(q[rod.dofs].reshape(len(rod.dofs), -1, 3))
        count = len(rod.element.directors)
        y, z = (count + rod.element.directors.index(m) - 1 for m in ((1, 0), (0, 1)))
        determinant = np.einsum("epi,epi->ep", v[:, :, 0], np.cross(v[:, :, y], v[:, :, z]))
        worst = np.unravel_index(np.argmin(determinant), determinant.shape)
        if determinant[worst] <= 0.0:
            return rod.rod.name, int(worst[0]), float(determinant[worst])
    return None


def _rate(model: Model, result: NewtonResult) -> float:
    """Largest dimensionless |dq / d load factor| by the last factorisation."""
    if result.lu is None:
        return 0.0
    dq = model.solve_linear(result.lu, model.residual(result.q).Q_ext)
    return float(np.max(np.abs(dq / model.unit), initial=0.0))


def _reason(model: Model, trace: Trace, result: NewtonResult) -> Status:
    """Status of a search that ended at the smallest step."""
    if result.outcome is Outcome.NOT_FINITE:
        return Status.NOT_FINITE
    if result.converged:  # the only reason to refuse a converged step
        return Status.INVERTED_ELEMENT
    if smallest_stretch(model, trace.q) < UNSTABLE_STRETCH:
        return Status.MATERIAL_UNSTABLE
    if len(trace.rates) > 2 and trace.rates[-1] > LIMIT_POINT_RATE * float(np.median(trace.rates)):
        return Status.LIMIT_POINT
    return Status.NOT_CONVERGED


def smallest_stretch(model: Model, q: Floats) -> float:
    """Smallest axial stretch |r_x| at the axial points."""
    stretch = [
        np.linalg.norm(rod.elastic.generalised(q[rod.dofs].reshape(len(rod.dofs), -1, 3))[:, :, 0], axis=-1)
        for rod in model.rods
    ]
    return float(min(s.min() for s in stretch))
