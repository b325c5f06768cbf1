"""The motion that brings together two sections which are apart in the reference, as an assembly does."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.mesh import reference_axis
from ancf.rotation import log
from ancf.scene import Rod

Floats = NDArray[np.float64]

FOLLOWED = 200  # places along two rods; a step turns them by less than half a turn up to 100 turns


def closing_motion(rod_a: Rod, at_a: float, rod_b: Rod, at_b: float) -> tuple[Floats, Floats]:
    """Displacement [m] and rotation vector [rad] that bring section a to b: X_b - X_a and Log(F_b F_a^T).

    X and F are place and axes in the reference, in SCS. Rods may be curved by several turns against each
    other, which no logarithm knows: it is followed along both from their bases.
    """
    share = np.linspace(0.0, 1.0, FOLLOWED)
    (X_a, F_a), (X_b, F_b) = (_placed(rod, at * share) for rod, at in ((rod_a, at_a), (rod_b, at_b)))
    rotation = np.zeros(3)
    for a, b in zip(F_a, F_b, strict=True):
        rotation = nearest_turn(log(b @ a.T), rotation)
    return X_b[-1] - X_a[-1], rotation


def nearest_turn(rotation: Floats, former: Floats) -> Floats:
    """The rotation vector (3,) of the same rotation, by whole turns nearest to a former one."""
    angle = np.linalg.norm(rotation)
    axis = rotation if angle > 0.0 else former
    if not np.any(axis):
        return rotation
    axis = axis / np.linalg.norm(axis)
    return (angle + 2.0 * np.pi * np.round((axis @ former - angle) / (2.0 * np.pi))) * axis


def _placed(rod: Rod, at: Floats) -> tuple[Floats, Floats]:
    """Positions (n, 3) [m] and axes (n, 3, 3), as columns, of sections in the reference, in SCS."""
    position, frame = reference_axis(at * rod.length, rod.curvature)
    A_o = rod.base.rotation
    return rod.base.position + position @ A_o.T, A_o @ frame
