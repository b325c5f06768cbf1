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
from ancf.residual import Residual

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
# After a step this small the next one, some square of it, needs no new tangent: the last one is as wrong as
# the step was long (a chord step; Kelley, Iterative Methods for Linear and Nonlinear Equations, 1995, ch. 5).
# It is a quarter of a solve in four iterations.
CHORD_STEP = 1e-6
# A step that would turn a section inside out is halved, at most to this share.
SMALLEST_SHARE = 1.0 / 64.0
# Contact is known near where it is looked at: a longer step (in rod lengths) is taken in part.
LONGEST = 0.1
# Near a critical point rounding of the residual moves a soft shape by more than the tolerance: a step so
# small that no longer falls is noise, and the residual alone decides.
NOISE_STEP, NOISE_RATIO = 1e-7, 0.1
# Of the step before the last one, over which a step says that friction goes to and fro. Then the step ends
# where forces work along it by no more than this share of what they do at its beginning.
REPEATS, STILL_WORKS, SEARCHES = 0.5, 0.3, 12
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
    OVERTURNED = "a rotational spring is turned by half a turn or more"
    CHATTERING = "tendons change between taut and slack without end"


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


class NewtonRun:
    """One Newton iteration under way: `advance` makes a linear step until `done`.

    One linear solve is one iteration. `result` holds the last iterate whatever happens; a failure is an
    `Outcome`. With a `border` the load factor is where it starts.
    """

    def __init__(self, model: Model, q: Floats, load_factor: float, border: Border | None = None) -> None:
        self.model = model
        self.border = border
        self.q = model.admissible(q)
        self.q_previous: Floats | None = None
        self.load_factor = load_factor
        self.result = NewtonResult(Outcome.TOO_MANY, self.q, load_factor, np.inf)
        self.done = False
        self._quiet = 0
        self.keeps_factors = False  # whether those at hand will do for the next step
        model.search(self.q)
        self._sides: list[tuple[bool | None, ...]] = []  # tried so far; see tendon_length.py
        if model.constraints is not None:
            model.constraints.take_sides(self.q)
        if model.inside_out(self.q):
            self.end(Outcome.INVERTED)

    def end(self, outcome: Outcome) -> None:
        """Nothing more is to be done."""
        self.result.outcome = outcome
        self.done = True

    def advance(self, forces: Residual, flat: Floats | None) -> None:
        """One linear step from the forces and the tangent at q; None: with the factors at hand."""
        outcome = self._step(forces, flat)
        if outcome is not None:
            self.end(outcome)

    def _step(self, forces: Residual, flat: Floats | None) -> Outcome | None:
        """The step; its outcome, None where the iteration goes on."""
        model, result, options = self.model, self.result, self.model.scene.solver
        g = model.system.project(forces.at(self.load_factor))
        if not _measure(model, result, g) or not (flat is None or np.isfinite(flat).all()):
            return Outcome.NOT_FINITE
        if flat is not None:
            try:
                result.lu, result.flat = model.system.factorise(flat), flat
            except SingularMatrixError:
                return Outcome.SINGULAR
        assert result.lu is not None
        if self.border is None:
            dq, change = model.system.solve(result.lu, -g), 0.0
        else:
            dq, change = self.border.step(result.lu, g, forces.Q_ext, self.q, self.load_factor)
        step = max(model.largest_motion(dq), abs(change) / max(abs(self.load_factor), 1.0))
        iteration = len(result.history) + 1
        result.history.append(Iteration(self.load_factor, iteration, result.residual, step))
        if not np.isfinite(step):
            return Outcome.NOT_FINITE
        lost = iteration >= PATIENCE and step > max(1.0, FALLING * result.history[-2].step)
        if step > DIVERGED_STEP or lost:
            return Outcome.DIVERGED
        share = min(1.0, LONGEST / step) if model.settling and step > 0.0 else 1.0
        if model.path_dependent and self._repeats():
            share = self._turning_point(share * dq) * share
        while share >= SMALLEST_SHARE and model.inside_out(self.q + share * dq):
            share *= 0.5
        if share < SMALLEST_SHARE:
            return Outcome.INVERTED
        self.q_previous, self.q = self.q, self.q + share * dq
        self.load_factor += share * change
        self.keeps_factors = model.eased and self.border is None and step <= CHORD_STEP
        noise = step <= NOISE_STEP and iteration > 1 and step > NOISE_RATIO * result.history[-2].step
        outcome = None
        if share == 1.0 and (step <= options.tolerance or noise):
            outcome = self._check()
        result.q, result.load_factor = self.q, self.load_factor
        return outcome

    def _repeats(self) -> bool:
        """Whether steps repeat each other: back and forth over a corner, from sticking to slipping."""
        steps = [entry.step for entry in self.result.history[-3:]]
        return len(steps) == 3 and steps[2] > REPEATS * steps[0] and steps[2] > NOISE_STEP

    def _turning_point(self, dq: Floats) -> float:
        """Share of a step at which the forces stop working along it (Matthies and Strang 1979), at most 1.

        By regula falsi (Illinois) on G(s) = dq . g(q + s dq), to a share of G(0).
        """

        def work(s: float) -> float:
            forces = self.model.residual(self.q + s * dq, self.load_factor)
            return float(forces.at(self.load_factor) @ dq)

        low, high, G_low, G_high = 0.0, 1.0, work(0.0), work(1.0)
        first, s = abs(G_low), 1.0
        if not G_low * G_high < 0.0:
            return 1.0
        for _ in range(SEARCHES):
            s = (low * G_high - high * G_low) / (G_high - G_low)
            G = work(s)
            if abs(G) <= STILL_WORKS * first:
                break
            if G * G_high < 0.0:
                low, G_low = high, G_high
            else:
                G_low *= 0.5
            high, G_high = s, G
        return s

    def _check(self) -> Outcome | None:
        """Converged if the residual at the new iterate agrees; stuck if it has not so often."""
        model, result = self.model, self.result
        assert result.flat is not None
        result.floor = FLOOR_FACTOR * float(np.finfo(float).eps) * model.system.row_sum(result.flat, self.q)
        forces = model.residual(self.q, self.load_factor)
        finite = _measure(model, result, model.system.project(forces.at(self.load_factor)))
        if finite and result.residual <= max(model.scene.solver.tolerance, result.floor):
            return self._settled()
        self._quiet += 1
        return Outcome.STAGNATED if self._quiet == STAGNATION else None

    def _settled(self) -> Outcome | None:
        """An equilibrium: it counts where constraints are met as they are meant; tendons may change side."""
        model, constraints = self.model, self.model.constraints
        if not model.is_known(self.q):
            return Outcome.OVERTURNED
        if constraints is None:
            return Outcome.CONVERGED
        self._sides.append(constraints.sides)
        wrong = constraints.wrong_side(self.q, model.scene.solver.tolerance)
        if wrong is not None:
            self._quiet, first = 0, not wrong.side
            q = constraints.choose_sides(model.scene, self.q)
            if constraints.sides not in self._sides:
                self.q = q
                return None
            for one, side in zip(constraints.tendons, self._sides[-1], strict=True):
                one.side = first if one is wrong else side
            return Outcome.CHATTERING if constraints.sides in self._sides else None
        return Outcome.CONVERGED if constraints.closed(self.q, self.load_factor) else Outcome.OFF_PATH

    @property
    def sides_tried(self) -> int:
        """How often tendons have changed between taut and slack."""
        return len(self._sides)


def newton(
    model: Model,
    q: Floats,
    load_factor: float,
    max_iterations: int,
    deadline: float = np.inf,
    border: Border | None = None,
) -> NewtonResult:
    """Solve g(q) = 0 at a load factor from the start q (n,), brought onto the supports first.

    `deadline` is a value of time.perf_counter().
    """
    run = NewtonRun(model, q, load_factor, border)
    while not run.done and len(run.result.history) < max_iterations * (1 + run.sides_tried):
        if time.perf_counter() > deadline:
            run.end(Outcome.OUT_OF_TIME)
            break
        try:
            if run.keeps_factors:
                forces, flat = model.residual(run.q, run.load_factor), None
            else:
                forces, flat = model.residual_and_tangent(run.q, run.load_factor, run.q_previous)
        except np.linalg.LinAlgError:  # a section collapsed to a line: its rotation is undefined
            run.end(Outcome.NOT_FINITE)
            break
        run.advance(forces, flat)
    if model.constraints is not None:
        model.constraints.leave_sides()
    return run.result


def _measure(model: Model, result: NewtonResult, g: Floats) -> bool:
    """Store the dimensionless residual; False when it is not finite."""
    scaled = np.abs(g / model.force_unit)
    result.worst_dof = int(np.argmax(scaled))
    result.residual = float(scaled[result.worst_dof])
    return bool(np.isfinite(result.residual))
