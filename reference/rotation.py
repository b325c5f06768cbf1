"""Rotations in three dimensions: exponential, logarithm, integrated exponential, quaternions.

Symbols
-------
v        rotation vector (axis times angle), [rad]
phi      its length, [rad]
q        quaternion (w, x, y, z); Exp(v) has q = (cos(phi/2), sin(phi/2) v/phi)
hat(v)   skew matrix, hat(v) a = v x a
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Below this angle a three-term Taylor series is exact to rounding (next term phi^6/362880 < 3e-18).
SMALL_ANGLE = 1e-2


def hat(v: ArrayLike) -> Array:
    """Skew matrix with hat(v) a = v x a. `v` (..., 3); returns (..., 3, 3)."""
    v = np.asarray(v, dtype=float)
    out = np.zeros((*v.shape[:-1], 3, 3))
    out[..., 2, 1], out[..., 0, 2], out[..., 1, 0] = v[..., 0], v[..., 1], v[..., 2]
    return out - np.swapaxes(out, -1, -2)


def cross(a: Array, b: Array) -> Array:
    """Cross product of the last axes, broadcast; several times faster than np.cross on small arrays."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def exp(v: ArrayLike) -> Array:
    """Rotation matrix of a rotation vector (Rodrigues).

    Exp(v) = I + (sin phi/phi) hat(v) + ((1 - cos phi)/phi^2) hat(v)^2, the second factor written as
    2 sin^2(phi/2)/phi^2 so that it does not cancel. `v` (..., 3) [rad]; returns (..., 3, 3).
    """
    v = np.asarray(v, dtype=float)
    phi = np.linalg.norm(v, axis=-1)[..., None, None]
    K = hat(v)
    return np.eye(3) + np.sinc(phi / np.pi) * K + 0.5 * np.sinc(phi / (2 * np.pi)) ** 2 * (K @ K)


def exp_integral(v: ArrayLike) -> Array:
    """Integral of Exp(x v) over x from 0 to 1.

    I + ((1 - cos phi)/phi^2) hat(v) + ((phi - sin phi)/phi^3) hat(v)^2 (the left Jacobian of SO(3)); a Taylor
    series in phi replaces the last factor at small angles. `v` (..., 3) [rad]; returns (..., 3, 3).
    """
    v = np.asarray(v, dtype=float)
    phi = np.linalg.norm(v, axis=-1)
    safe = np.where(phi < SMALL_ANGLE, 1.0, phi)
    x = phi**2
    series = 1 / 6 - x / 120 + x**2 / 5040
    third = np.where(phi < SMALL_ANGLE, series, (safe - np.sin(safe)) / safe**3)
    K = hat(v)
    second = 0.5 * np.sinc(phi / (2 * np.pi)) ** 2
    return np.eye(3) + second[..., None, None] * K + third[..., None, None] * (K @ K)


def quaternion(R: ArrayLike) -> Array:
    """Unit quaternion (w, x, y, z), w >= 0, of a rotation matrix.

    The largest of the four components is taken from the diagonal (Shepperd 1978), so that nothing cancels.
    `R` (..., 3, 3); returns (..., 4).
    """
    R = np.asarray(R, dtype=float)
    m = np.moveaxis(R, (-2, -1), (0, 1))
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    # Rows of 4 q q^T: each is the quaternion times 4 times one of its components.
    rows = np.array(
        [
            [1 + trace, m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], 1 - trace + 2 * m[0, 0], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
            [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], 1 - trace + 2 * m[1, 1], m[1, 2] + m[2, 1]],
            [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], 1 - trace + 2 * m[2, 2]],
        ]
    )
    best = np.argmax(rows[np.arange(4), np.arange(4)], axis=0)
    q = np.take_along_axis(np.moveaxis(rows, (0, 1), (-2, -1)), best[..., None, None], axis=-2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.where(q[..., :1] < 0, -q, q)


def matrix(q: ArrayLike) -> Array:
    """Rotation matrix of a quaternion (w, u): (w^2 - u.u) I + 2 u u^T + 2 w hat(u).

    `q` (..., 4), unit (a longer one gives |q|^2 times a rotation); returns (..., 3, 3).
    """
    q = np.asarray(q, dtype=float)
    w, u = q[..., :1, None], q[..., 1:]
    uu = np.sum(u * u, axis=-1)[..., None, None]
    return (w**2 - uu) * np.eye(3) + 2 * u[..., :, None] * u[..., None, :] + 2 * w * hat(u)


def log(R: ArrayLike) -> Array:
    """Rotation vector of a rotation matrix, of length <= pi.

    v = 2 atan2(|u|, w) u/|u| with the quaternion (w, u), accurate from 0 to pi. `R` (..., 3, 3); returns
    (..., 3) [rad]. At exactly pi the sign of the axis is arbitrary.
    """
    q = quaternion(R)
    w, u = q[..., 0], q[..., 1:]
    length = np.linalg.norm(u, axis=-1)
    safe = np.where(length > 0, length, 1.0)
    # For tiny angles 2 atan2(l, w)/l -> 2 (w = 1 there).
    factor = np.where(length > 0, 2 * np.arctan2(length, w) / safe, 2.0)
    return factor[..., None] * u
