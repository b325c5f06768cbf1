r"""The rotation vector as a coordinate: how it changes with the spin, and the moment of a rotational spring.

With theta = Log(R), a = |theta|, and the spin dw, dR = hat(dw) R,

    dtheta = L dw,   L = I - 1/2 hat(theta) + c hat(theta)^2,   c = (1 - (a/2) cot(a/2))/a^2

(Cardona and Geradin, Int. J. Numer. Methods Eng. 26 (1988) 2403), so that the potential
1/2 theta . k theta, k a constant symmetric matrix, exerts on the section

    m = -L^T v,   v = k theta,   dm = -(d(L^T) v + L^T k dtheta),
    d(L^T) v = 1/2 dtheta x v + (c'/a) (theta . dtheta) (theta (theta . v) - a^2 v)
               + c (dtheta (theta . v) + theta (v . dtheta) - 2 (theta . dtheta) v).

L^T theta = theta: where all stiffnesses are equal m = -k theta. c is smooth up to a = 2 pi, where it is
infinite: (2 pi)^2 c = 2 sum_n zeta(2 n) x^(n - 1), x = (a/2 pi)^2, of which all but 1/(1 - x) converges as
(x/4)^n. Log itself jumps where a passes pi: theta is known below half a turn.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import zetac

from ancf.rotation import hat

Floats = NDArray[np.float64]

TERMS = 14  # (1/16)^14 = 1e-17 at a = pi
_ZETA = np.array([float(zetac(2 * n)) for n in range(1, TERMS + 1)])  # zeta(2 n) - 1
_ZETA_SLOPE = np.arange(1, TERMS) * _ZETA[1:]


def coefficient(angle: Floats) -> tuple[Floats, Floats]:
    """c and c'/a (...,) at angles a (...,) [rad] up to pi."""
    x = (angle / (2.0 * np.pi)) ** 2
    powers = x[..., None] ** np.arange(TERMS)
    c = 1.0 / (1.0 - x) + powers @ _ZETA
    slope = 1.0 / (1.0 - x) ** 2 + powers[..., :-1] @ _ZETA_SLOPE
    return c / (2.0 * np.pi**2), slope / (4.0 * np.pi**4)


def rate(theta: Floats) -> Floats:
    """L (..., 3, 3) with dtheta = L dw at rotation vectors theta (..., 3)."""
    c, _ = coefficient(np.linalg.norm(theta, axis=-1))
    turn = hat(theta)
    return np.eye(3) - 0.5 * turn + c[..., None, None] * turn @ turn


def spring_moment(theta: Floats, k: Floats) -> Floats:
    """m (..., 3) [N m] of the potential 1/2 theta . k theta, k (..., 3, 3) [N m/rad]."""
    v = k @ theta[..., None]
    return -(np.swapaxes(rate(theta), -1, -2) @ v)[..., 0]


def spring_moment_change(theta: Floats, k: Floats) -> Floats:
    """dm/dw (..., 3, 3) of `spring_moment`."""
    v = (k @ theta[..., None])[..., 0]
    angle = np.linalg.norm(theta, axis=-1)
    c, c_a = (value[..., None, None] for value in coefficient(angle))
    L = rate(theta)
    theta_v = np.sum(theta * v, axis=-1)[..., None]
    across = theta * theta_v - (angle**2)[..., None] * v
    change = (
        -0.5 * hat(v)
        + c_a * across[..., :, None] * theta[..., None, :]
        + c
        * (
            theta_v[..., None] * np.eye(3)
            + theta[..., :, None] * v[..., None, :]
            - 2.0 * v[..., :, None] * theta[..., None, :]
        )
    )
    return -(change + np.swapaxes(L, -1, -2) @ k) @ L
