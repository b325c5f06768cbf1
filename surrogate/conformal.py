"""Split-conformal error radius: with which distance a model's answers are right in 95 of 100 cases.

With the errors e_1 .. e_n of n rows that the model has not seen, the ceil((n + 1) level)-th smallest is
exceeded by the error of a new row with a probability of at most 1 - level, whatever the model, if the new
row comes from the same design as the n. Off that design, and for disturbed poses, it promises nothing.

The promise is a mean over sets of n rows. The share of new rows inside one set's radius is scattered about it
as Beta(k, n + 1 - k), k the rank, with the deviation sqrt(level (1 - level)/(n + 2)): 1.4 % for the 228
validation rows of the presets. Hence rows of their own, more of them, and spread over the box of the moments
as new rows are, whatever the design of the training rows.

Source: Vovk, Gammerman, Shafer, Algorithmic Learning in a Random World (2005); Vovk, Conditional validity of
inductive conformal predictors (2012), proposition 2a; Lei et al., JASA 113 (2018).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from surrogate.arm import Arm
from surrogate.evaluate import Model
from surrogate.problem import Problem, Samples, box_design, solved

Floats = NDArray[np.float64]

LEVEL = 0.95
CALIBRATION_ROWS = 1024  # three deviations of the coverage are 2 %
SEED = 23  # of their design


@dataclass(frozen=True)
class ErrorRadius:
    """Radii that hold with the probability `level` on the design of the calibration rows."""

    level: float
    rows: int
    position: float  # m, of the tip in closed loop
    moment: float  # N m, Euclidean norm

    @property
    def deviation(self) -> float:
        """Of the share of new rows inside the radii, over sets of calibration rows."""
        return math.sqrt(self.level * (1.0 - self.level) / (self.rows + 2))

    def as_dict(self) -> dict[str, float | None]:
        """Plain data for JSON; a radius without bound is None."""
        values = {**asdict(self), "deviation": self.deviation}
        return {key: value if math.isfinite(value) else None for key, value in values.items()}


def radius_text(radius: Mapping[str, float | None]) -> str:
    """The two radii of `ErrorRadius.as_dict` in words."""
    position, moment = radius["position"], radius["moment"]
    if position is None or moment is None:
        return f"unknown from {radius['rows']} rows: too few, or too many without an equilibrium"
    return f"{position:.3g} m of the tip, {moment:.3g} N m"


def conformal_radius(errors: Floats, level: float = LEVEL) -> float:
    """The radius of errors (n,) of rows that were not trained on; inf where n is too small for the level."""
    rank = math.ceil((len(errors) + 1) * level - 1e-9)
    return math.inf if rank > len(errors) else float(np.sort(errors)[rank - 1])


def errors_of(model: Model, arm: Arm, samples: Samples) -> tuple[Floats, Floats]:
    """Errors (n,) of the tip [m], in closed loop, and of the moment [N m]; inf without an equilibrium."""
    moments = model(samples.poses)
    found = arm.solve(moments)
    away = np.linalg.norm(found.poses[:, :, 0] - samples.poses[:, :, 0], axis=1)
    away[found.status != "converged"] = np.inf
    return away, np.linalg.norm(moments - samples.moments, axis=1)


def calibration(problem: Problem, rows: int = CALIBRATION_ROWS, seed: int = SEED) -> Samples:
    """Rows for `calibrated`, solved here: spread over the box of the problem, independent of its own rows."""
    return solved(problem.arm, box_design(problem.bounds, rows, seed))


def calibrated(model: Model, arm: Arm, samples: Samples, level: float = LEVEL) -> ErrorRadius:
    """Radii of a model from rows that it has not been trained on."""
    away, gap = errors_of(model, arm, samples)
    return ErrorRadius(level, len(samples), conformal_radius(away, level), conformal_radius(gap, level))


def coverage(radius: ErrorRadius, model: Model, arm: Arm, samples: Samples) -> tuple[float, float]:
    """Shares of new rows whose errors of tip and of moment are within the radii."""
    away, gap = errors_of(model, arm, samples)
    return float(np.mean(away <= radius.position)), float(np.mean(gap <= radius.moment))
