"""Load steps: predictor, Newton, growth and cut-back, and a typed reason when no equilibrium is found.

The full load is tried first from the predictor, or from the reference when there is none. If that
fails the load grows in steps: each start is extrapolated in local measures (rod_shape.py), a failed step is
cut, quick steps grow. Nothing goes on from a failed step: the path continues from the last equilibrium.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.failure import is_collapsed, status_of_failure
from ancf.model import Model
from ancf.newton import Iteration, NewtonResult, Outcome, newton
from ancf.path import Path
from ancf.predictor import load_start
from ancf.settling import settled
from ancf.solution import Status

if TYPE_CHECKING:
    from ancf.continuation import Followed

Floats = NDArray[np.float64]

DIRECT_ITERATIONS = 25  # for the full load in one step
STEP_ITERATIONS = 10  # in a load step: beyond it a shorter step is cheaper
QUICK_ITERATIONS = 6  # a step that took no more may grow
GROWTH = 2.0
CUT = 0.25
SHARE_OF_ROOM = 0.8  # of the way in which contact allows a step
SMALLEST_STEP = 1e-6  # of the full load
BRANCH_STEP = 0.01  # a step from a stable to an unstable equilibrium is taken only if it is shorter
FIRST_TURN = 1.0  # rad or rod lengths by which the linear solution of the first load step may move sections


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
    budget_used: bool = False  # max_steps
    stable: bool | None = None  # the last equilibrium; None where it was not decided
    followed: Followed | None = None  # the path, where it was followed


def find_equilibrium(model: Model, start: Floats | None = None, deadline: float | None = None) -> Trace:
    """Equilibrium at the full load, or the last one on the way to it.

    Parameters
    ----------
    start : coordinates (n,) to begin from (a resumed state); Newton tries them before anything else
    deadline : value of time.perf_counter(); None: `max_seconds` from now
    """
    options = model.scene.solver
    if deadline is None:
        deadline = time.perf_counter() + options.max_seconds
    trace = Trace(Status.NOT_CONVERGED, model.q0)
    if model.scene.follows_path:
        return _follow(model, trace, deadline)  # a path begins at the reference, whatever the start
    model.release()
    if start is not None and _try_at_once(model, trace, start, deadline):
        return trace
    # A prescribed motion is walked, and so is contact: at once they would lead anywhere, or through it.
    if options.predictor == "auto" and model.longest_step >= 1.0 and not model.settling:
        bent = load_start(model, deadline)
        # One long step may land on an unstable branch beyond a buckling load: then the path decides.
        if (
            _try_at_once(model, trace, model.q0 if bent is None else bent, deadline)
            and trace.stable is not False
        ):
            return trace
    if trace.status is Status.OUT_OF_TIME:
        return trace
    return _walk(model, trace, deadline)


def _try_at_once(model: Model, trace: Trace, start: Floats, deadline: float) -> bool:
    """Newton at the full load; False when it fails, which is a cut-back."""
    result = _contact_settled(model, start, newton(model, start, 1.0, DIRECT_ITERATIONS, deadline), deadline)
    trace.history += result.history
    if _accept(model, trace, result, 1.0, is_stable(model, result)):
        trace.status = Status.CONVERGED
        return True
    trace.cutbacks += 1
    if result.outcome is Outcome.OUT_OF_TIME:
        trace.status = Status.OUT_OF_TIME
    return False


def _contact_settled(model: Model, before: Floats, result: NewtonResult, deadline: float) -> NewtonResult:
    """The run once contact has settled; off the path where it has come through an obstacle from `before`."""
    if result.converged and model.room(before, result.q) < 1.0:
        result.outcome = Outcome.OFF_PATH
    result = settled(model, result, deadline)
    if not result.converged:
        model.release()
    return result


def _accept(
    model: Model, trace: Trace, result: NewtonResult, load_factor: float, stable: bool | None
) -> bool:
    """Take over a converged step whose configuration is not turned inside out."""
    if result.converged and not is_collapsed(model, result.q):
        trace.q, trace.load_factor = result.q, load_factor
        trace.residual, trace.floor = result.residual, result.floor
        trace.stable = stable
        trace.steps += 1
        return True
    trace.failure, trace.tried = result, load_factor
    return False


def is_stable(model: Model, result: NewtonResult) -> bool | None:
    """Whether an equilibrium is a minimum of the potential.

    Loads without a potential: False for an odd number of negative eigenvalues, by the sign of the
    determinant, else None; an even number, and flutter, cannot be seen so.
    """
    if not result.converged or result.lu is None or result.flat is None:
        return None
    if model.conservative:
        try:
            return model.is_minimum(result.q, result.load_factor, result.lu, result.flat)
        except ArithmeticError:  # on a critical point itself
            return None
    return False if model.determinant_sign(result.q, result.load_factor, result.lu) < 0 else None


def _follow(model: Model, trace: Trace, deadline: float) -> Trace:
    """The path through limit points, and onto the buckled branch where the scene asks for it."""
    from ancf.continuation import follow

    options, stability = model.scene.solver, model.scene.stability
    buckled = stability is not None and stability.branch == "buckled"
    path = trace.followed = follow(model, 1.0, options.max_steps, deadline, buckled)
    last = path.points[-1]
    trace.q, trace.load_factor = last.q, last.load_factor
    trace.residual, trace.floor = last.residual, last.floor
    trace.steps, trace.cutbacks = path.steps, trace.cutbacks + path.cutbacks
    trace.history += path.history
    trace.stable = last.negative == 0 if model.conservative else False if last.negative else None
    if path.reached:
        trace.status = Status.CONVERGED
        return trace
    trace.budget_used, trace.tried = path.out_of_steps, 1.0
    if path.failure is not None:
        trace.failure, trace.tried = path.failure, path.failure.load_factor
        trace.status = status_of_failure(model, trace, path.failure)
    elif path.limit_point is not None:
        trace.status = Status.LIMIT_POINT
    return trace


def _walk(model: Model, trace: Trace, deadline: float) -> Trace:
    """Load steps from zero with growth and cut-back."""
    options = model.scene.solver
    if trace.load_factor == 1.0:  # an unstable equilibrium was found at once: forget it
        trace.q, trace.load_factor, trace.stable, trace.status = model.q0, 0.0, None, Status.NOT_CONVERGED
        trace.steps, trace.cutbacks = 0, trace.cutbacks + 1
        trace.residual, trace.floor, trace.failure = 0.0, 0.0, None
    path = Path(model, model.q0)
    step = _first_step(model)
    while trace.load_factor < 1.0:
        step = min(step, model.longest_step)
        target = trace.load_factor + step
        if target > 1.0 - 1e-9:
            target = 1.0
        if trace.steps + trace.cutbacks >= options.max_steps:
            trace.budget_used, trace.tried = True, target
            return trace
        most = DIRECT_ITERATIONS if model.settling else STEP_ITERATIONS
        result = newton(model, _start(model, path, trace, target), target, most, deadline)
        room = model.room(trace.q, result.q) if result.converged else np.inf
        if target == 1.0 or room < 1.0:
            result = _contact_settled(model, trace.q, result, deadline)
        trace.history += result.history
        stable = is_stable(model, result)
        taken = target - trace.load_factor
        jumped = stable is False and trace.stable is not False
        # A prescribed motion may buckle a rod at any small part of it.
        shortest = BRANCH_STEP * (1.0 if model.longest_step == np.inf else target)
        if jumped and taken > shortest:
            # Stable before, unstable after: a stable branch may turn off in between. Look closer.
            trace.cutbacks += 1
            step = taken * CUT
            continue
        if _accept(model, trace, result, target, stable):
            path.add(target, result.q)
            rate = _rate(model, result)
            trace.rates.append(model.largest_motion(rate))
            if len(result.history) <= QUICK_ITERATIONS:
                step *= GROWTH
            step = min(step, model.longest_change(result.q, rate), SHARE_OF_ROOM * room * taken)
            continue
        trace.cutbacks += 1
        step = taken * (CUT if room >= 1.0 else min(SHARE_OF_ROOM * room, CUT))
        if step < SMALLEST_STEP or result.outcome is Outcome.OUT_OF_TIME:
            trace.status = status_of_failure(model, trace, result)
            return trace
    trace.status = Status.CONVERGED
    return trace


def _first_step(model: Model) -> float:
    """First load step: the linear solution may turn the sections by about a radian."""
    forces, flat = model.residual_and_tangent(model.q0, 0.0)
    try:
        dq = model.system.solve(model.system.factorise(flat), forces.Q_ext)
    except ArithmeticError:
        return 1.0
    largest = model.largest_motion(dq)
    step = min(FIRST_TURN / largest if largest > 0.0 else 1.0, model.longest_change(model.q0, dq))
    return float(np.clip(step, SMALLEST_STEP, 1.0))


def _start(model: Model, path: Path, trace: Trace, target: float) -> Floats:
    if len(path.points) > 1:
        return path.extrapolate(target)
    forces, flat = model.residual_and_tangent(trace.q, trace.load_factor)
    try:
        dq = model.system.solve(model.system.factorise(flat), -forces.at(target))
    except ArithmeticError:
        return trace.q
    return path.from_tangent(dq) if np.isfinite(dq).all() else trace.q


def _rate(model: Model, result: NewtonResult) -> Floats:
    """dq / d load factor (n,) by the last factorisation."""
    if result.lu is None:
        return np.zeros(model.n)
    return model.system.solve(result.lu, model.residual(result.q, result.load_factor).Q_ext)
