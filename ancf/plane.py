r"""The plane in which Newton looks for the next point of a path, and the metric in which it is a plane.

Distance along the path is measured in dimensionless coordinates and the load factor,

    <(a, k), (b, m)> = 1/N sum_i a_i b_i / unit_i^2 + w^2 k m,     N nodal vectors,

w the motion that unit load factor would cause linearly: a snap is not overlooked because loads are large.

Across a direction (t, t_l) through a predicted point (q_p, l_p), with the load factor unknown:

    K dq - Q_ext dl = -g,    <(t, t_l), (q - q_p + dq, l - l_p + dl)> = 0.

K stays banded: two right sides, one more for each `held` motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancf.band import Factors
from ancf.model import Model

Floats = NDArray[np.float64]
Direction = tuple[Floats, float]  # of a motion (n,) [SI] and of the load factor


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
