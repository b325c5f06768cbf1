"""Trained networks on raw poses: metres in, newton metres out, without torch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from surrogate.architecture import Architecture
from surrogate.problem import Problem, Samples

if TYPE_CHECKING:
    from surrogate.training import Schedule

Floats = NDArray[np.float64]
Network = TypeVar("Network")

# Targets are given in units of which the largest moment has 20: of the ranges tried, that comes closest to
# the published errors of table 1, which are not those of z-scored targets.
UNITS = 20.0


@dataclass(frozen=True, eq=False)
class Normaliser:
    """z = (p - mean)/deviation, by component, from training rows only (paper sec. 3.1)."""

    mean: Floats  # (inputs,)
    deviation: Floats  # (inputs,)

    @classmethod
    def of(cls, x: Floats) -> Normaliser:
        """Of training rows (n, inputs); a component that never changes is left as it is."""
        deviation = x.std(axis=0)
        return cls(x.mean(axis=0), np.where(deviation > 0.0, deviation, 1.0))

    def __call__(self, x: Floats) -> Floats:
        """The normalised inputs (.., inputs)."""
        return (x - self.mean) / self.deviation


@dataclass(frozen=True, eq=False)
class PoseNetwork:
    """A network on the 3 x 4 image of a pose, its normaliser included."""

    architecture: Architecture
    flat: Floats  # (parameters,)
    normaliser: Normaliser
    moment_unit: float  # N m of one unit of the outputs

    @cached_property
    def weights(self) -> list[tuple[Floats, Floats]]:
        """W, b of the layers."""
        return self.architecture.unpack(self.flat)

    def predict(self, poses: Floats) -> Floats:
        """Moments (n, 3) [N m] of poses (n, 3, 4) [m, -]; one pose (3, 4) gives (3,)."""
        x = image(poses)
        return self.architecture.forward(self.weights, self.normaliser(x)) * self.moment_unit


def image(poses: Floats) -> Floats:
    """The 3 x 4 image (fig. 5) of poses (.., 3, 4), columns r, r_x, r_y, r_z, flat by rows (.., 12)."""
    return np.asarray(poses, dtype=float).reshape(*np.shape(poses)[:-2], 12)


def moment_unit(bounds: Floats, units: float = UNITS) -> float:
    """N m of one unit of the targets, of which the largest moment has `units`."""
    return float(np.abs(bounds).max()) / units


@dataclass(frozen=True, eq=False)
class NetworkFit(Generic[Network]):
    """Networks of several seeds, and their losses (S, epochs) in units squared of their targets."""

    networks: list[Network]
    training_loss: Floats
    validation_loss: Floats


def fit_networks(
    problem: Problem,
    architecture: Architecture,
    seeds: Sequence[int],
    schedule: Schedule,
    units: float = UNITS,
) -> NetworkFit[PoseNetwork]:
    """Train one architecture on the raw pose with several seeds at once, MSE and Adam."""
    from surrogate.training import train_seeds

    normaliser, unit = Normaliser.of(image(problem.train.poses)), moment_unit(problem.bounds, units)

    def rows(samples: Samples) -> tuple[Floats, Floats]:
        return normaliser(image(samples.poses)), samples.moments / unit

    trained = train_seeds(architecture, rows(problem.train), rows(problem.validation), schedule, seeds)
    networks = [PoseNetwork(architecture, flat, normaliser, unit) for flat in trained.flat]
    return NetworkFit(networks, trained.training_loss, trained.validation_loss)
