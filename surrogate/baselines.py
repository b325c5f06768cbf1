"""What a network has to beat: closed form; polynomial, radial basis functions, perceptron on the logarithm.

Features of a pose in body axes: position over the length and the *unwrapped* logarithm of the rotation of the
section (helix.py), six numbers without a jump where the angle passes pi. Targets: v = M L/(E I) in body axes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surrogate.architecture import LOG_MLP, Architecture
from surrogate.arm import Arm
from surrogate.helix import helix_inverses
from surrogate.networks import NetworkFit, Normaliser
from surrogate.problem import Problem, Samples

if TYPE_CHECKING:
    from collections.abc import Sequence

    from surrogate.training import Schedule

Floats = NDArray[np.float64]

DEGREE = 3
FEATURES = 6
# Factors of each monomial among (1, x_1, .., x_6).
CHOICES = np.array(list(combinations_with_replacement(range(FEATURES + 1), DEGREE)))
# Singular values below this share of the largest are noise: the six features lie near three dimensions.
RANK = 1e-10


def log_features(arm: Arm, poses: Floats) -> Floats:
    """Features (n, 6) of poses (n, 3, 4)."""
    body = arm.body_poses(poses)
    _, log, _ = helix_inverses(body, arm.twist_ratio)
    return np.concatenate([body[:, :, 0], log], axis=1)


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """The inverse of the thin arm: no data at all."""

    arm: Arm

    def predict(self, poses: Floats) -> Floats:
        """Moments (n, 3) [N m] of poses (n, 3, 4), or (3,) of one."""
        rows = np.asarray(poses, dtype=float).reshape(-1, 3, 4)
        v, _, _ = helix_inverses(self.arm.body_poses(rows), self.arm.twist_ratio)
        return self.arm.moments(v).reshape(*np.shape(poses)[:-2], 3)


@dataclass(frozen=True, eq=False)
class Polynomial:
    """Cubic polynomial of the six features, 84 terms for each moment, by least squares."""

    arm: Arm
    normaliser: Normaliser
    coefficients: Floats  # (84, 3)

    @classmethod
    def fit(cls, arm: Arm, samples: Samples) -> Polynomial:
        """Of solved rows."""
        x = log_features(arm, samples.poses)
        normaliser = Normaliser.of(x)
        terms = _terms(normaliser(x))
        coefficients = np.linalg.lstsq(terms, arm.body_moments(samples.moments), rcond=RANK)[0]
        return cls(arm, normaliser, np.asarray(coefficients, dtype=float))

    def predict(self, poses: Floats) -> Floats:
        """Moments (n, 3) [N m] of poses (n, 3, 4), or (3,) of one."""
        rows = np.asarray(poses, dtype=float).reshape(-1, 3, 4)
        v = _terms(self.normaliser(log_features(self.arm, rows))) @ self.coefficients
        return self.arm.moments(v).reshape(*np.shape(poses)[:-2], 3)


@dataclass(frozen=True, eq=False)
class RadialBasis:
    """Cubic radial basis functions with a linear tail through all training rows."""

    arm: Arm
    normaliser: Normaliser
    features: Floats  # (n, 6) normalised
    targets: Floats  # (n, 3)

    @classmethod
    def fit(cls, arm: Arm, samples: Samples) -> RadialBasis:
        """Of solved rows."""
        x = log_features(arm, samples.poses)
        normaliser = Normaliser.of(x)
        return cls(arm, normaliser, normaliser(x), arm.body_moments(samples.moments))

    @cached_property
    def _interpolator(self) -> Any:
        from scipy.interpolate import RBFInterpolator

        return RBFInterpolator(self.features, self.targets, kernel="cubic", degree=1, smoothing=1e-12)

    def predict(self, poses: Floats) -> Floats:
        """Moments (n, 3) [N m] of poses (n, 3, 4), or (3,) of one."""
        rows = np.asarray(poses, dtype=float).reshape(-1, 3, 4)
        v = self._interpolator(self.normaliser(log_features(self.arm, rows)))
        return self.arm.moments(v).reshape(*np.shape(poses)[:-2], 3)


@dataclass(frozen=True, eq=False)
class LogNetwork:
    """A perceptron on the six features: what the features are worth to a network that knows nothing else."""

    arm: Arm
    flat: Floats  # (parameters,)
    normaliser: Normaliser
    scale: float  # of v
    architecture: Architecture = LOG_MLP

    @cached_property
    def weights(self) -> list[tuple[Floats, Floats]]:
        """W, b of the layers."""
        return self.architecture.unpack(self.flat)

    def predict(self, poses: Floats) -> Floats:
        """Moments (n, 3) [N m] of poses (n, 3, 4), or (3,) of one."""
        rows = np.asarray(poses, dtype=float).reshape(-1, 3, 4)
        x = self.normaliser(log_features(self.arm, rows))
        v = self.scale * self.architecture.forward(self.weights, x)
        return self.arm.moments(v).reshape(*np.shape(poses)[:-2], 3)


def fit_log_networks(problem: Problem, seeds: Sequence[int], schedule: Schedule) -> NetworkFit[LogNetwork]:
    """Perceptrons of several seeds, trained at once."""
    from surrogate.training import train_seeds

    arm = problem.arm
    normaliser = Normaliser.of(log_features(arm, problem.train.poses))
    scale = float(np.abs(arm.body_moments(problem.train.moments)).max())

    def rows(samples: Samples) -> tuple[Floats, Floats]:
        return normaliser(log_features(arm, samples.poses)), arm.body_moments(samples.moments) / scale

    trained = train_seeds(LOG_MLP, rows(problem.train), rows(problem.validation), schedule, seeds)
    networks = [LogNetwork(arm, flat, normaliser, scale) for flat in trained.flat]
    return NetworkFit(networks, trained.training_loss, trained.validation_loss)


def _terms(x: Floats) -> Floats:
    """Monomials (n, 84) of degree 0 to 3 of six numbers (n, 6)."""
    padded = np.column_stack([np.ones(len(x)), x])
    return padded[:, CHOICES].prod(axis=2)
