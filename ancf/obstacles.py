r"""Rigid obstacles: how far a point is from their surface, in which direction, and how the direction turns.

With the point r, the distance D(r), its normal n = dD/dr and H = dn/dr:

    plane through p          D = n . (r - p),            H = 0
    ball round c             D = |r - c| - R,            H = (I - n n^T)/|r - c|
    cylinder round c + s a   D = |r_perp - c_perp| - R,  H = (I - n n^T - a a^T)/|r_perp - c_perp|
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TINY = 1e-300  # m: on the axis of an obstacle every direction leads out


class Obstacle(ABC):
    """A rigid body at rest."""

    shape: str
    radius: float  # m, that of the body; inf for a plane

    @abstractmethod
    def distance(self, r: Floats) -> tuple[Floats, Floats, Floats]:
        """D (...,) [m], n (..., 3) and H (..., 3, 3) [1/m] at points r (..., 3) [m, SCS]."""


@dataclass(frozen=True, eq=False)
class Plane(Obstacle):
    """A half space: its normal (3,), of length 1, points out of it."""

    point: Floats
    normal: Floats
    shape = "plane"
    radius = np.inf

    def distance(self, r: Floats) -> tuple[Floats, Floats, Floats]:
        """See `Obstacle.distance`."""
        n = np.broadcast_to(self.normal, r.shape)
        return (r - self.point) @ self.normal, n, np.zeros((*r.shape, 3))


@dataclass(frozen=True, eq=False)
class Sphere(Obstacle):
    """A ball."""

    centre: Floats
    radius: float
    shape = "sphere"

    def distance(self, r: Floats) -> tuple[Floats, Floats, Floats]:
        """See `Obstacle.distance`."""
        return _round(r - self.centre, self.radius, np.eye(3))


@dataclass(frozen=True, eq=False)
class Cylinder(Obstacle):
    """A cylinder without ends; `axis` has length 1."""

    point: Floats
    axis: Floats
    radius: float
    shape = "cylinder"

    def distance(self, r: Floats) -> tuple[Floats, Floats, Floats]:
        """See `Obstacle.distance`."""
        across = np.eye(3) - np.outer(self.axis, self.axis)
        return _round((r - self.point) @ across, self.radius, across)


def _round(arm: Floats, radius: float, across: Floats) -> tuple[Floats, Floats, Floats]:
    size = np.maximum(np.linalg.norm(arm, axis=-1), TINY)
    n = arm / size[..., None]
    H = (across - n[..., :, None] * n[..., None, :]) / size[..., None, None]
    return size - radius, n, H
