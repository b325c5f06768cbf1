r"""Path following: equilibria (q, l) along their arc, through limit points of the load factor l.

Distance along the path is measured in dimensionless coordinates and the load factor,

    <(a, k), (b, m)> = 1/N sum_i a_i b_i / unit_i^2 + w^2 k m,     N nodal vectors,

w the motion that unit load factor would cause linearly: a snap is not overlooked because loads are large.

From the last points the next one is predicted by a polynomial in the arc (path.py); Newton then searches the
plane through it across the predicted direction (t, t_l), with the load factor unknown:

    K dq - Q_ext dl = -g,    <(t, t_l), (q - q_p + dq, l - l_p + dl)> = 0.

K stays banded: two right sides, one more for each `held` motion. (Riks 1979; Wriggers, Nonlinear Finite
Element Methods, 2008, ch. 5.)
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ancf.band import Factors, SingularMatrixError
from ancf.failure import is_collapsed
from ancf.model import Model
from ancf.newton import Iteration, NewtonResult, Outcome, newton
from ancf.path import Path
from ancf.spectrum import Spectrum

Floats = NDArray[np.float64]
Direction = tuple[Floats, float]  # of a motion (n,) [SI] and of the load factor

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


@dataclass(frozen=True)
class Held:
    """Motions (k, n) [SI] that may not change: of solutions that differ by them one is singled out."""

    motions: Floats
    at: Floats  # (n,)


@dataclass(frozen=True)
class Metric:
    """The inner product of motions and load factors; `load` is w."""

    model: Model
    load: float

    def inner(self, a: Floats, b: Floats) -> float:
        """Of two motions (n,) [SI]."""
        m = self.model.motions
        return 3.0 / m * float(np.sum((a * b / self.model.unit**2)[:m]))

    def dot(self, a: Direction, b: Direction) -> float:
        """Of two directions, motion and load factor."""
        return self.inner(a[0], b[0]) + self.load**2 * a[1] * b[1]

    def unit(self, motion: Floats, load_factor: float) -> Direction:
        """Direction of length 1."""
        size = np.sqrt(self.dot((motion, load_factor), (motion, load_factor)))
        return motion / size, load_factor / size


class Plane:
    """Border of Newton's method: the plane across a direction (t, t_l) through (q, l)."""

    def __init__(
        self, metric: Metric, q: Floats, load_factor: float, direction: Direction, held: Held | None
    ) -> None:
        self.metric = metric
        self.q, self.load_factor = q, load_factor
        self.direction = direction
        self.held = held

    def step(
        self, lu: Factors, g: Floats, Q_ext: Floats, q: Floats, load_factor: float
    ) -> tuple[Floats, float]:
        """See `newton.Border`."""
        metric, held = self.metric, self.held
        model = metric.model
        motions = np.empty((0, model.n)) if held is None else held.motions
        columns = np.column_stack([-g, Q_ext, *(-m / model.unit * model.force_unit for m in motions)])
        x = model.system.solve(lu, columns)
        gaps = [metric.dot(self.direction, (q - self.q, load_factor - self.load_factor))]
        if held is not None:
            gaps += [metric.inner(m, q - held.at) for m in motions]
        rows = [self.direction[0], *motions]
        A = np.array([[metric.inner(t, column) for column in x[:, 1:].T] for t in rows])
        A[0, 0] += metric.load**2 * self.direction[1]
        right = -np.array(gaps) - np.array([metric.inner(t, x[:, 0]) for t in rows])
        try:
            found = np.linalg.solve(A, right)
        except np.linalg.LinAlgError:
            return np.full(model.n, np.nan), np.nan
        return x[:, 0] + x[:, 1:] @ found, float(found[0])


def path_from_reference(model: Model, deadline: float = np.inf) -> Follower:
    """The path of equilibria that begins at the unloaded reference, towards more load.

    Raises `ArithmeticError` where it has no direction: a mechanism, or loads that overflow.
    """
    forces, flat = model.residual_and_tangent(model.q0, 0.0)
    rate = model.system.solve(model.system.factorise(flat), forces.Q_ext)
    size = np.sqrt(Metric(model, 0.0).inner(rate, rate))
    if not np.isfinite(size):
        raise OverflowError("the loads overflow")
    metric = Metric(model, max(float(size), LEAST_LOAD_WEIGHT))
    path = Follower(metric, Spectrum(model), deadline)
    path.begin(PathPoint(0.0, 0.0, model.q0, 0, (rate, 1.0)), metric.unit(rate, 1.0))
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

    def begin(self, point: PathPoint, direction: Direction) -> None:
        """First point: an equilibrium, and where to go from it."""
        self.points.append(replace(point, tangent=direction))
        self._path = Path(self.model, point.q, point.arc)

    def enter(self, mode: Floats, size: float) -> PathPoint | None:
        """The point of another branch at a distance `size` along a mode of the first point."""
        first = self.points[0]
        q = self.model.admissible(self._path.from_tangent(size * mode))
        direction = (mode, 0.0)
        plane = Plane(self.metric, first.q + size * mode, first.load_factor, direction, self.held)
        found = self._solve(first, q, first.load_factor, plane, direction)
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
        share = (load_factor - a.load_factor) / (b.load_factor - a.load_factor)
        found = self.between(share, fixed=load_factor)
        if found is not None:
            self.points[-1] = found
        return found

    def between(self, share: float, fixed: float | None = None) -> PathPoint | None:
        """The point of the path at a share of the way between the last two, or near it at a `fixed` load."""
        a, b = self.points[-2:]
        q = self.model.admissible(self._path.extrapolate(a.arc + share * (b.arc - a.arc)))
        load_factor = a.load_factor + share * (b.load_factor - a.load_factor)
        direction = self.metric.unit(b.q - a.q, b.load_factor - a.load_factor)
        plane = Plane(self.metric, a.q + share * (b.q - a.q), load_factor, direction, self.held)
        if fixed is not None:
            load_factor = fixed
            plane = Plane(self.metric, q, fixed, (np.zeros(self.model.n), 1.0), self.held)
        found = self._solve(a, q, load_factor, plane, direction)
        return None if found is None else found[0]

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
