"""The path of equilibria from the unloaded rod to its loads, through limit points and onto other branches.

Used for ``method = "arclength"``, for ``branch = "buckled"`` and for the buckling factor of `[stability]`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ancf.arclength import PathPoint, path_from_reference
from ancf.band import SingularMatrixError
from ancf.critical import CriticalPoint, critical_points, turn_off
from ancf.failure import LARGEST_TURN, LARGEST_WAVE, largest_turn, largest_wave
from ancf.model import Model
from ancf.newton import Iteration, NewtonResult, Outcome

Floats = NDArray[np.float64]


@dataclass
class Followed:
    """A path and what was met on it.

    reached: whether its last point has the load factor asked for; tried_branch, turned_off: whether a
    bifurcation was met where the other branch is wanted, and whether that was entered; failure: the Newton
    iteration that ended it; out_of_steps: its budget did; too_coarse: elements came to turn or to be pressed
    so much that a critical point would be one of the mesh.
    """

    points: list[PathPoint] = field(default_factory=list)
    critical: list[CriticalPoint] = field(default_factory=list)
    history: list[Iteration] = field(default_factory=list)
    steps: int = 0
    cutbacks: int = 0
    reached: bool = False
    tried_branch: bool = False
    turned_off: bool = False
    out_of_steps: bool = False
    too_coarse: bool = False
    failure: NewtonResult | None = None

    @property
    def limit_point(self) -> CriticalPoint | None:
        """The first limit point of the load factor."""
        return next((c for c in self.critical if c.kind == "limit"), None)


def _between(a: float, value: float, b: float) -> bool:
    return a != b and min(a, b) <= value <= max(a, b)


def follow(
    model: Model,
    to: float,
    max_steps: int,
    deadline: float,
    buckled: bool = False,
    first_critical: bool = False,
) -> Followed:
    """Follow the path from the reference to a load factor.

    Parameters
    ----------
    to : load factor at which the path is left, the first time it gets there
    max_steps : steps and cut-backs together
    deadline : value of time.perf_counter()
    buckled : turn off onto the other branch at the first bifurcation
    first_critical : stop at the first critical point
    """
    found = Followed()
    try:
        path = path_from_reference(model, deadline)
    except ArithmeticError as error:
        singular = isinstance(error, SingularMatrixError)
        outcome = Outcome.SINGULAR if singular else Outcome.NOT_FINITE
        found.failure = NewtonResult(outcome, model.q0, to, np.inf)
        found.points.append(PathPoint(0.0, 0.0, model.q0, 0, (np.zeros(model.n), 1.0)))
        return found
    found.points.append(path.points[0])
    while True:
        if found.steps + found.cutbacks + path.cutbacks >= max_steps:
            found.out_of_steps = True
            break
        before = path.points[-1]
        point = path.advance()
        if point is None:
            found.failure = path.failure
            break
        crossed = _between(before.load_factor, to, point.load_factor)
        if crossed:
            point = path.at_load(to)
            if point is None:  # a limit point lies close by: come nearer
                path.retreat()
                continue
        found.steps += 1
        if largest_turn(model, point.q) > LARGEST_TURN or largest_wave(model, point.q) > LARGEST_WAVE:
            found.too_coarse = True  # critical points from here on would be those of the mesh
        if found.too_coarse and first_critical:
            break
        met = [] if found.too_coarse else list(critical_points(path))
        first = next((c for c in met if c.kind == "bifurcation"), None)
        if buckled and not found.tried_branch and first is not None:
            found.tried_branch = True
            met = met[: met.index(first) + 1]
            branch = turn_off(path, first)
            if branch is not None:
                found.turned_off = True
                found.history += path.history
                found.cutbacks += path.cutbacks
                path, point = branch, branch.points[-1]
                crossed = _between(first.load_factor, to, point.load_factor)
                if crossed:
                    point = path.at_load(to) or point
                    crossed = point.load_factor == to
        found.critical += met
        found.points += [*(c.point for c in met), point]
        if first_critical and met:
            break
        if crossed:
            found.reached = True
            break
    found.history += path.history
    found.cutbacks += path.cutbacks
    return found
