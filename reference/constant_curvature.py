"""Constant-curvature pose of the paper (eq. 47-48), with the misprint of eq. 47 shown.

Symbols
-------
theta    bending angle of the whole arm, [rad]
phi      direction of the bending plane, [rad]
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.helix import RodShape

Array = NDArray[np.float64]


def constant_curvature_pose(theta: float, phi: float, length: float) -> RodShape:
    """Tip pose of an arm along Z bent into a circular arc, eq. 47 corrected and eq. 48.

    R = [[C^2 (c-1) + 1, S C (c-1), -C s], [S C (c-1), S^2 (c-1) + 1, -S s], [C s, S s, c]],
    x = (L/theta) [C (c-1), S (c-1), s], with C, S of phi and c, s of theta.

    Parameters
    ----------
    theta, phi : [rad]
    length : [m]

    Returns
    -------
    RodShape with one station, s = length; the rotation is relative to the straight arm.

    Notes
    -----
    Equals the helix of the tip moment (EI theta/L)(sin phi, -cos phi, 0), e = Z: no torsion, hence exact for
    the rod. Smooth at theta = 0. Webster and Jones 2010, table 1 (same arc, other sign of theta).
    """
    C, S, c, s = np.cos(phi), np.sin(phi), np.cos(theta), np.sin(theta)
    half = np.sin(theta / 2)
    sideways = -half * np.sinc(theta / (2 * np.pi))  # (c - 1)/theta without cancellation
    k = -2 * half**2  # c - 1
    R = np.array([[C * C * k + 1, S * C * k, -C * s], [S * C * k, S * S * k + 1, -S * s], [C * s, S * s, c]])
    position = length * np.array([C * sideways, S * sideways, np.sinc(theta / np.pi)])
    return RodShape(np.array([length]), position[None, :], R[None, :, :])


def printed_eq47(theta: float, phi: float) -> Array:
    """Matrix of eq. 47 as printed, with cos^2 phi in the (2,2) entry: no rotation unless S^2 = C^2 or c = 1.

    R^T R - I has entries up to 1.3. Returns (3, 3); for the record of the misprint only.
    """
    R = constant_curvature_pose(theta, phi, 1.0).rotation[0].copy()
    R[1, 1] = np.cos(phi) ** 2 * (np.cos(theta) - 1) + 1
    return R


def constant_curvature_moment(theta: float, phi: float, length: float, EI: float) -> Array:
    """Tip moment (EI theta/L)(sin phi, -cos phi, 0) [N m] of this pose; the arm lies along Z."""
    return EI * theta / length * np.array([np.sin(phi), -np.cos(phi), 0.0])
