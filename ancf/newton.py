"""Newton iteration at one load factor: dimensionless step and residual, mixed-integration-point tangent.

Converged means: last step <= tolerance (lengths by L, slopes by 1), or small and only noise of rounding, and
residual <= max(tolerance, floor). The floor is what coordinates stored in float64 leave at the worst
equation, eps sum_j |K_ij| |q_j|: about 10 eps n_el A L^2 / I for a rod of n_el elements, more near
incompressibility. Nothing is divided by the load.

With a `Border` the load factor is unknown too, and conditions on it and the coordinates come along.
"""

from __future__ import annotations

import enum
import time
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ancf.band import Factors, SingularMatrixError
from ancf.model import Model

Floats = NDArray[np.float64]

# A step of this many rod lengths has left every basin of attraction worth waiting for.
DIVERGED_STEP = 1e3
# Good runs halve their step each time once the first few linear steps have stretched the rod; from this
# iteration on, a step of over a rod length that is not falling says that this start leads nowhere.
PATIENCE = 7
FALLING = 0.7
# Residual that rounding leaves, in units of eps sum_j |K_ij| |q_j|: positions and slopes are stored to eps/2;
# strain products, stress and force add a few roundings each. Measured 0.02 to 0.6 over the hard cases.
FLOOR_FACTOR = 1.0
# A step that would turn a section inside out is halved, at most to this share.
SMALLEST_SHARE = 1.0 / 64.0
# Near a critical point rounding of the residual moves a soft shape by more than the tolerance: a step so
# small that no longer falls is noise, and the residual alone decides.
NOISE_STEP, NOISE_RATIO = 1e-7, 0.1
# Steps that stay below the tolerance while the residual does not fall: stuck above the floor.
STAGNATION = 4


class Outcome(enum.Enum):
    """How a Newton iteration ended."""

    CONVERGED = "converged"
    TOO_MANY = "iteration limit reached"
    DIVERGED = "iterates diverged"
    NOT_FINITE = "a number was not finite"
    SINGULAR = "tangent is singular"
    INVERTED = "a section turns inside out"
    STAGNATED = "residual stagnates above its floor"
    OUT_OF_TIME = "time limit reached"
    OFF_PATH = "the step lands on another branch"


@dataclass(frozen=True)
class Iteration:
    """One linear solve: the residual before it and the step it made, both dimensionless."""

    load_factor: float
    iteration: int
    residual: float
    step: float


class Border(Protocol):
    """Conditions that determine the load factor together with the coordinates."""

    def step(
        self, lu: Factors, g: Floats, Q_ext: Floats, q: Floats, load_factor: float
    ) -> tuple[Floats, float]:
        """Newton step (n,) and change of the load factor, from the residual g and the load at factor 1."""
        ...


@dataclass
class NewtonResult:
    """Outcome, last coordinates and load factor, history and the last factorisation."""

    outcome: Outcome
    q: Floats
    load_factor: float
    residual: float
    history: list[Iteration] = field(default_factory=list)
    lu: Factors | None = None
    flat: Floats | None = None  # the tangent behind `lu`
    worst_dof: int = 0
    floor: float = 0.0  # dimensionless residual that float64 leaves here

    @property
    def converged(self) -> bool:
        """Whether the equilibrium was found."""
        return self.outcome is Outcome.CONVERGED


def newton(
    model: Model,
    q: Floats,
    load_factor: float,
    max_iterations: int,
    deadline: float = np.inf,
    border: Border | None = None,
) -> NewtonResult:
    """Solve g(q) = 0 at a load factor from the start q (n,), brought onto the supports first.

    With a `border` the load factor is where it starts.

    One linear solve is one iteration. Returns the last iterate whatever happened; a failure is an `Outcome`.
    `deadline` is a value of time.perf_counter().
    """
    options = model.scene.solver
    q = model.admissible(q)
    result = NewtonResult(Outcome.TOO_MANY, q, load_factor, np.inf)
    if model.inside_out(q):
        return _ended(result, Outcome.INVERTED)
    q_previous: Floats | None = None
    quiet = 0
    for iteration in range(1, max_iterations + 1):
        if time.perf_counter() > deadline:
            return _ended(result, Outcome.OUT_OF_TIME)
        try:
            forces, flat = model.residual_and_tangent(q, load_factor, q_previous)
        except np.linalg.LinAlgError:  # a section collapsed to a line: its rotation is undefined
            return _ended(result, Outcome.NOT_FINITE)
        g = model.system.project(forces.at(load_factor))
        if not _measure(model, result, g) or not np.isfinite(flat).all():
            return _ended(result, Outcome.NOT_FINITE)
        try:
            result.lu, result.flat = model.system.factorise(flat), flat
        except SingularMatrixError:
            return _ended(result, Outcome.SINGULAR)
        if border is None:
            dq, change = model.system.solve(result.lu, -g), 0.0
        else:
            dq, change = border.step(result.lu, g, forces.Q_ext, q, load_factor)
        step = max(model.largest_motion(dq), abs(change) / max(abs(load_factor), 1.0))
        result.history.append(Iteration(load_factor, iteration, result.residual, step))
        if not np.isfinite(step):
            return _ended(result, Outcome.NOT_FINITE)
        lost = iteration >= PATIENCE and step > max(1.0, FALLING * result.history[-2].step)
        if step > DIVERGED_STEP or lost:
            return _ended(result, Outcome.DIVERGED)
        share = 1.0
        while share >= SMALLEST_SHARE and model.inside_out(q + share * dq):
            share *= 0.5
        if share < SMALLEST_SHARE:
            return _ended(result, Outcome.INVERTED)
        q_previous, q = q, q + share * dq
        load_factor += share * change
        noise = step <= NOISE_STEP and iteration > 1 and step > NOISE_RATIO * result.history[-2].step
        if share == 1.0 and (step <= options.tolerance or noise):
            result.floor = FLOOR_FACTOR * float(np.finfo(float).eps) * model.system.row_sum(flat, q)
            forces = model.residual(q, load_factor)
            finite = _measure(model, result, model.system.project(forces.at(load_factor)))
            if finite and result.residual <= max(options.tolerance, result.floor):
                if not model.joints_closed(q, load_factor):
                    return _ended(result, Outcome.OFF_PATH)
                result.q, result.load_factor = q, load_factor
                return _ended(result, Outcome.CONVERGED)
            quiet += 1
            if quiet == STAGNATION:
                return _ended(result, Outcome.STAGNATED)
        result.q, result.load_factor = q, load_factor
    return result


def _measure(model: Model, result: NewtonResult, g: Floats) -> bool:
    """Store the dimensionless residual; False when it is not finite."""
    scaled = np.abs(g / model.force_unit)
    result.worst_dof = int(np.argmax(scaled))
    result.residual = float(scaled[result.worst_dof])
    return bool(np.isfinite(result.residual))


def _ended(result: NewtonResult, outcome: Outcome) -> NewtonResult:
    result.outcome = outcome
    return result
