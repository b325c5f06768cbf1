"""Honest measures of an inverse model: the moments it gives are solved again, and the tip is compared.

A model is anything that turns poses (n, 3, 4) into moments (n, 3) [N m].
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surrogate.arm import Arm
from surrogate.inverse import pose_mismatch
from surrogate.problem import Problem, Samples, box_design, solved
from surrogate.trajectory import reference_trajectory

Floats = NDArray[np.float64]
Model = Callable[[Floats], Floats]

TEST_ROWS = 512  # of the independent designs
# A random split of a sweep hides the error off its grid: this ratio of the two tip errors warns.
LEAK = 3.0
# Errors below this share of the length are not worth a warning, however they compare.
LEAK_FLOOR = 1e-5
NOISE_POSITION, NOISE_GRADIENT = 1e-3, 1e-3  # of the length; of a unit vector
OUTSIDE = 1.25  # the box that is out of the workspace, over the one of the data
LATENCY_CALLS = 2000


@dataclass(frozen=True)
class Spread:
    """Mean, median, 95th percentile and largest of an error."""

    mean: float
    median: float
    p95: float
    max: float

    @classmethod
    def of(cls, errors: Floats) -> Spread:
        """Of errors (n,)."""
        return cls(
            float(np.mean(errors)), float(np.median(errors)), float(np.quantile(errors, 0.95)),
            float(np.max(errors)),
        )  # fmt: skip


@dataclass(frozen=True)
class Scores:
    """Errors of a model on one set of poses."""

    rows: int
    unsolved: int  # rows whose moments have no equilibrium; they are in no other number
    tip: Spread  # closed loop, % of the length
    angle: Spread  # closed loop, degrees, of the section
    mse: float  # N^2 m^2, per component
    mse_z: float  # of moments over the deviation of the training moments
    r2: float  # coefficient of determination, mean of the components

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return asdict(self)


def score(model: Model, arm: Arm, samples: Samples, deviation: Floats) -> Scores:
    """Errors of a model on solved poses, through the solver.

    Parameters
    ----------
    deviation : (3,) [N m], of the training moments: the unit of `mse_z`
    """
    moments = np.asarray(model(samples.poses))
    gap = moments - samples.moments
    found = arm.solve(moments)
    good = found.status == "converged"
    away, turned = pose_mismatch(arm, found.poses[good], samples.poses[good])
    spread = samples.moments.var(axis=0)
    varied = spread > 1e-20
    return Scores(
        len(samples),
        int((~good).sum()),
        Spread.of(100.0 * away / arm.length),
        Spread.of(np.degrees(turned)),
        float(np.mean(gap**2)),
        float(np.mean((gap / deviation) ** 2)),
        float(np.mean(1.0 - (gap**2).mean(axis=0)[varied] / spread[varied])),
    )


@dataclass(frozen=True, eq=False)
class Designs:
    """Sets of poses on which models are compared; none but `split` knows the training design."""

    split: Samples  # the test rows of the data set's own split
    off_grid: Samples  # an independent design in the same box
    trajectory: Samples | None  # constant-curvature poses, with the moments of the thin arm; None without one
    noise: Samples  # the independent design, its poses disturbed
    outside: Samples  # moments beyond the box

    def named(self) -> dict[str, Samples]:
        """By name, in order."""
        return {name: samples for name, samples in vars(self).items() if samples is not None}


def designs(problem: Problem, rows: int = TEST_ROWS, seed: int = 11) -> Designs:
    """The sets of poses for a problem; solves some thousand equilibria."""
    arm, bounds = problem.arm, problem.bounds
    off_grid = solved(arm, box_design(bounds, rows, seed))
    rng = np.random.default_rng([seed, 3])
    scale = np.array([NOISE_POSITION * arm.length] + [NOISE_GRADIENT] * 3)
    noise = Samples(off_grid.poses + scale * rng.normal(size=off_grid.poses.shape), off_grid.moments)
    wide = box_design(bounds, 4 * rows, seed + 1, OUTSIDE)  # half of them are inside
    beyond = ((wide < bounds[:, 0]) | (wide > bounds[:, 1])).any(axis=1)
    trajectory = None if arm.without_closed_form else trajectory_of(problem)
    return Designs(problem.test, off_grid, trajectory, noise, solved(arm, wide[beyond][:rows]))


def trajectory_of(problem: Problem) -> Samples:
    """The reference trajectory, as far as the moments of the box bend the arm."""
    from surrogate.trajectory import trajectory_moments

    largest = problem.arm.largest_bending(problem.bounds)
    return Samples(reference_trajectory(problem.arm, largest), trajectory_moments(problem.arm, largest))


class LeakWarning(UserWarning):
    """The error on the test split says nothing about poses off the training design."""


def leak_guard(split: Scores, off_grid: Scores, name: str) -> str:
    """Warn when the error off the training design is over `LEAK` times that of the random split.

    Returns the warning, or "".
    """
    ratio = off_grid.tip.mean / max(split.tip.mean, 1e-300)
    if ratio <= LEAK or off_grid.tip.mean <= 100.0 * LEAK_FLOOR:
        return ""
    text = (
        f"{name}: mean tip error {off_grid.tip.mean:.3g} % of the length on an independent design, "
        f"{split.tip.mean:.3g} % on the test split of the data ({ratio:.1f} times, limit {LEAK:g}): the split"
        " leaks the design of the training rows; trust the former, or train on a Sobol design"
    )
    warnings.warn(text, LeakWarning, stacklevel=2)
    return text


def slab(bounds: Floats, axis: int = 1) -> Callable[[Floats], NDArray[np.bool_]]:
    """Picks moments in the fifth of the box above its middle fifth along one axis: a gap inside the box."""
    low, high = bounds[axis]
    begin, end = low + 0.6 * (high - low), low + 0.8 * (high - low)
    return lambda moments: (moments[:, axis] >= begin) & (moments[:, axis] < end)


def slab_score(problem: Problem, kind: str, seed: int = 0, epochs: int | None = None) -> Scores:
    """Errors inside a slab of the box by a model that was trained without the slab."""
    from surrogate.fit import fit

    rest, cut = problem.without(slab(problem.bounds), seed)
    (model,) = fit(rest, kind, [seed], epochs).models
    return score(model.predict, problem.arm, cut, rest.deviation)


def latency(model: Model, poses: Floats, calls: int = LATENCY_CALLS) -> tuple[float, float]:
    """p50 and p99 [s] of single poses (3, 4), one call each, in CPU time of the thread."""
    times = np.empty(calls)
    for number in range(calls):
        pose = poses[number % len(poses)]
        begin = time.thread_time()
        model(pose)
        times[number] = time.thread_time() - begin
    return float(np.quantile(times, 0.5)), float(np.quantile(times, 0.99))
