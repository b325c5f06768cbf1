r"""Path following: equilibria (q, l) along their arc, through limit points of the load factor l.

From the last points the next one is predicted by a polynomial in the arc (path.py); Newton then searches the
plane through it across the predicted direction (plane.py). (Riks 1979; Wriggers, Nonlinear Finite Element
Methods, 2008, ch. 5.)
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ancf.band import Factors, SingularMatrixError
from ancf.failure import is_collapsed
from ancf.model import Model
from ancf.newton import Iteration, NewtonResult, Outcome, newton
from ancf.path import Path
from ancf.plane import Direction, Held, Metric, Plane
from ancf.spectrum import Spectrum

Floats = NDArray[np.float64]

FIRST_LOAD = 0.1  # largest load factor of the first step
LONGEST_MOTION = 0.1  # rod lengths or radians (root mean square) in a step
GROWTH = 2.0  # of a step, and of the load factor by one step
CUT = 0.35
# A column that load hardly moves: less would leave the load factor to rounding of the motion.
LEAST_LOAD_WEIGHT = 1e-3
SHORTEST_STEP = 1e-6  # of the longest
STEP_ITERATIONS = 9
QUICK_ITERATIONS = 5
SAME_WAY = 0.8  # cosine between neighbouring chords of the path: less is a jump to another branch


@dataclass(frozen=True)
class PathPoint:
    """An equilibrium of the path.

    arc: distance along it; negative: negative eigenvalues of the tangent, for loads without a potential 0 or
    1 by the sign of the determinant; tangent: unit direction of the path (n,) and of the load factor.
    """

    arc: float
    load_factor: float
    q: Floats
    negative: int
    tangent: Direction
    log_determinant: float = 0.0
    residual: float = 0.0
    floor: float = 0.0


def path_from_reference(model: Model, deadline: float = np.inf) -> Follower:
    """The path of equilibria that begins at the unloaded reference, towards more load.

    Raises `ArithmeticError` where it has no direction: a mechanism, or loads that overflow.
    """
    q = model.q0
    if any(effect.passive for effect in model.effects):  # a stretched spring pulls from the beginning
        unloaded = newton(model, q, 0.0, STEP_ITERATIONS, deadline)
        if not unloaded.converged:
            raise ArithmeticError("no equilibrium without load")
        q = unloaded.q
    forces, flat = model.residual_and_tangent(q, 0.0)
    rate = model.system.solve(model.system.factorise(flat), forces.Q_ext)
    size = np.sqrt(Metric(model, 0.0).inner(rate, rate))
    if not np.isfinite(size):
        raise OverflowError("the loads overflow")
    metric = Metric(model, max(float(size), LEAST_LOAD_WEIGHT))
    path = Follower(metric, Spectrum(model), deadline)
    path.begin(PathPoint(0.0, 0.0, q, 0, metric.unit(rate, 1.0)))
    return path


@dataclass
class Follower:
    """A path of equilibria, followed point by point; `failure` is the last Newton iteration that failed."""

    metric: Metric
    spectrum: Spectrum
    deadline: float = np.inf
    held: Held | None = None
    points: list[PathPoint] = field(default_factory=list)
    history: list[Iteration] = field(default_factory=list)
    cutbacks: int = 0
    failure: NewtonResult | None = None
    step: float = np.inf

    @property
    def model(self) -> Model:
        """What is followed."""
        return self.metric.model

    @property
    def held_motions(self) -> Floats | None:
        """Motions (k, n) that may not change."""
        return None if self.held is None else self.held.motions

    def begin(self, point: PathPoint) -> None:
        """First point: an equilibrium; its tangent is where to go from it."""
        self.points.append(point)
        self._path = Path(self.model, point.q, point.arc)

    def enter(self, size: float) -> PathPoint | None:
        """The point of a branch at a distance `size` from the first point along its tangent, a mode."""
        first = self.points[0]
        mode = first.tangent[0]
        q = self.model.admissible(self._path.from_tangent(size * mode))
        plane = Plane(self.metric, first.q + size * mode, first.load_factor, first.tangent, self.held)
        found = self._solve(first, q, first.load_factor, plane, first.tangent)
        if found is not None:
            self._append(found[0])
            self.step = size
        return None if found is None else found[0]

    def advance(self) -> PathPoint | None:
        """The next point of the path; None when no step succeeds, and `failure` says why."""
        last = self.points[-1]
        longest = self._longest(last)
        if not np.isfinite(longest):
            self.failure = NewtonResult(Outcome.NOT_FINITE, last.q, last.load_factor, np.inf)
            return None
        self.step = min(self.step, longest)
        while self.step >= SHORTEST_STEP * longest:
            if time.perf_counter() > self.deadline:
                self.failure = NewtonResult(Outcome.OUT_OF_TIME, last.q, last.load_factor, np.inf)
                return None
            found = self._point(last, self.step)
            if found is None:
                self.cutbacks += 1
                self.step *= CUT
                continue
            point, iterations = found
            self._append(point)
            if iterations <= QUICK_ITERATIONS:
                self.step *= GROWTH
            return point
        return None

    def retreat(self) -> None:
        """Take back the last point, and go on from the one before by shorter steps."""
        self.points.pop()
        self.cutbacks += 1
        self.step *= CUT
        self._path.take_back()

    def _append(self, point: PathPoint) -> None:
        self.points.append(point)
        self._path.add(point.arc, point.q)

    def _longest(self, last: PathPoint) -> float:
        """Longest step: the motion is limited, also what is prescribed, and the load factor may double."""
        t, t_l = last.tangent
        motion = np.sqrt(self.metric.inner(t, t))
        load = abs(t_l) / max(abs(last.load_factor), FIRST_LOAD)
        prescribed = max(abs(t_l) / self.model.longest_step, 1.0 / self.model.longest_change(last.q, t))
        return 1.0 / max(motion / LONGEST_MOTION, load / (GROWTH - 1.0), prescribed)

    def _point(self, last: PathPoint, step: float) -> tuple[PathPoint, int] | None:
        """The point a step ahead, and the iterations it took; None if none is found on this branch."""
        t, t_l = last.tangent
        if len(self.points) > 1:
            weights = self._path.weights(last.arc + step)
            q = self.model.admissible(self._path.extrapolate(last.arc + step))
            known = [point.load_factor for point in self.points[-len(weights) :]]
            load_factor = float(np.dot(weights, known))
            before = self._last_chord()
        else:
            q = self.model.admissible(self._path.from_tangent(step * t))
            load_factor, before = last.load_factor + step * t_l, last.tangent
        direction = self.metric.unit(q - last.q, load_factor - last.load_factor)
        plane = Plane(self.metric, q, load_factor, direction, self.held)
        return self._solve(last, q, load_factor, plane, before)

    def _solve(
        self, last: PathPoint, q: Floats, load_factor: float, plane: Plane, before: Direction
    ) -> tuple[PathPoint, int] | None:
        """Newton in a plane; the chord from `last` must go on in the direction `before`."""
        result = newton(self.model, q, load_factor, STEP_ITERATIONS, self.deadline, plane)
        self.history += result.history
        self.failure = result
        if not result.converged or is_collapsed(self.model, result.q):
            return None
        dq, dl = result.q - last.q, result.load_factor - last.load_factor
        chord = self.metric.unit(dq, dl)
        if not self.metric.dot(chord, before) >= SAME_WAY:
            result.outcome = Outcome.OFF_PATH
            return None
        assert result.lu is not None and result.flat is not None
        tangent = self._tangent(result.lu, self.model.residual(result.q, result.load_factor).Q_ext, chord)
        point = PathPoint(
            arc=last.arc + float(np.sqrt(self.metric.dot((dq, dl), (dq, dl)))),
            load_factor=result.load_factor,
            q=result.q,
            negative=self._negative(result.lu, result.flat, result.q, result.load_factor),
            tangent=tangent,
            log_determinant=result.lu.log_determinant,
            residual=result.residual,
            floor=result.floor,
        )
        return point, len(result.history)

    def _last_chord(self) -> Direction:
        a, b = self.points[-2:]
        return self.metric.unit(b.q - a.q, b.load_factor - a.load_factor)

    def at_load(self, load_factor: float) -> PathPoint | None:
        """Replace the last point by one at a load factor between the last two; None if none is found."""
        a, b = self.points[-2:]
        q = self._shape_between((load_factor - a.load_factor) / (b.load_factor - a.load_factor))
        plane = Plane(self.metric, q, load_factor, (np.zeros(self.model.n), 1.0), self.held)
        found = self._solve(a, q, load_factor, plane, self._last_chord())
        if found is None:
            return None
        self.points[-1] = found[0]
        return found[0]

    def between(self, share: float) -> PathPoint | None:
        """The point of the path at a share of the chord between the last two; None if none is found."""
        a, b = self.points[-2:]
        load_factor, chord = a.load_factor + share * (b.load_factor - a.load_factor), self._last_chord()
        plane = Plane(self.metric, a.q + share * (b.q - a.q), load_factor, chord, self.held)
        found = self._solve(a, self._shape_between(share), load_factor, plane, chord)
        return None if found is None else found[0]

    def _shape_between(self, share: float) -> Floats:
        a, b = self.points[-2:]
        return self.model.admissible(self._path.extrapolate(a.arc + share * (b.arc - a.arc)))

    def _tangent(self, lu: Factors, Q_ext: Floats, ahead: Direction) -> Direction:
        """Unit direction of the path: K dq = Q_ext dl; forward is where `ahead` points."""
        rate = self.model.system.solve(lu, Q_ext)
        direction = self.metric.unit(rate, 1.0)
        backwards = self.metric.dot(direction, ahead) < 0.0
        return (-direction[0], -direction[1]) if backwards else direction

    def _negative(self, lu: Factors, flat: Floats, q: Floats, load_factor: float) -> int:
        if not self.model.conservative:
            return int(lu.determinant_sign < 0)
        try:
            return self._negative_eigenvalues(flat, q, load_factor)
        except SingularMatrixError:  # at a critical point itself: as before it
            return self.points[-1].negative

    def _negative_eigenvalues(self, flat: Floats, q: Floats, load_factor: float) -> int:
        if self.held is None:
            return self.model.system.negative_eigenvalues(flat)
        # Along the held motions the tangent is singular; across them its eigenvalues are counted one by one.
        return self.spectrum.negative_across(q, load_factor, self.held.motions)
