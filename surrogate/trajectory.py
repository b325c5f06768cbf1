"""The reference trajectory of the paper (eq. 47-48, fig. 9): tips of constant-curvature arcs.

Symbols
-------
theta    bending angle of the whole arm [rad]
phi      direction of the bending plane [rad]
C, S     cosine and sine of phi; c, s of theta

    R = [[C^2 (c-1) + 1, S C (c-1), -C s], [S C (c-1), S^2 (c-1) + 1, -S s], [C s, S s, c]],
    x = (L/theta) [C (c-1), S (c-1), s],

eq. 47 with S^2 in the (2,2) entry: with the printed C^2 it is no rotation. It is the thin rod under the tip
moment (E I theta/L)(sin phi, -cos phi, 0) in SCS, so an arm along Z follows it up to (R/L)^2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from surrogate.arm import Arm

Floats = NDArray[np.float64]

POINTS = 100
TURNS = 2.0  # of the bending plane along the trajectory


def arc_rotation(theta: Floats, phi: Floats, printed: bool = False) -> Floats:
    """R of eq. 47 (n, 3, 3), corrected; `printed` gives it as the paper prints it."""
    C, S, c, s = np.cos(phi), np.sin(phi), np.cos(theta), np.sin(theta)
    k = -2.0 * np.sin(0.5 * theta) ** 2
    middle = C * C if printed else S * S
    rows = [
        [C * C * k + 1.0, S * C * k, -C * s],
        [S * C * k, middle * k + 1.0, -S * s],
        [C * s, S * s, c],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def arc_position(theta: Floats, phi: Floats) -> Floats:
    """x/L of eq. 48 (n, 3)."""
    side = -np.sin(0.5 * theta) * np.sinc(0.5 * theta / np.pi)  # (c - 1)/theta without cancellation
    return np.stack([np.cos(phi) * side, np.sin(phi) * side, np.sinc(theta / np.pi)], axis=-1)


def reference_trajectory(arm: Arm, largest: float, points: int = POINTS) -> Floats:
    """Poses (points, 3, 4) in SCS: theta rises and falls once, up to `largest`, while the plane turns.

    Eq. 47-48 hold for an arm along Z, whose gradients are R A_o; for another base they are turned with it.
    """
    t = np.linspace(0.0, 1.0, points)
    theta, phi = largest * np.sin(np.pi * t), 2.0 * np.pi * TURNS * t
    A_o = arm.rod.base.rotation
    # From axes whose Z is the arm's: the paper's own A_o.
    turn = A_o @ PAPER_BASE.T
    R = turn @ arc_rotation(theta, phi) @ turn.T
    position = arm.length * arc_position(theta, phi) @ turn.T + arm.rod.base.position
    return np.concatenate([position[:, :, None], R @ A_o], axis=2)


def trajectory_moments(arm: Arm, largest: float, points: int = POINTS) -> Floats:
    """Moments (points, 3) [N m], in the frame of the arm, under which the thin arm follows it."""
    t = np.linspace(0.0, 1.0, points)
    theta, phi = largest * np.sin(np.pi * t), 2.0 * np.pi * TURNS * t
    v = np.stack([np.zeros(points), -theta * np.cos(phi), -theta * np.sin(phi)], axis=1)
    return arm.moments(v)


PAPER_BASE = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])  # A_o of eq. 3
