"""Rotations: hat, exponential and logarithm, and the polar rotation of a section with its spin.

Arrays may carry leading batch axes. Small angles use series, so nothing is singular at the straight shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_SMALL_ANGLE = 1e-4  # below it the series to fourth order is exact in float64 (1e-16 / 720)

# Where the axial vector of a matrix takes its components: m[row, column] - m[column, row].
_AXIAL_ROW, _AXIAL_COLUMN = np.array([2, 0, 1]), np.array([1, 2, 0])

# hat(v) is linear in v: row k holds the skew matrix of unit vector k. One product beats six assignments.
_HAT = np.array(
    [
        [[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        [[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]],
        [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
    ]
).reshape(3, 9)


def hat(v: Floats) -> Floats:
    """Skew matrix (..., 3, 3) with hat(v) a = v x a."""
    v = np.asarray(v, dtype=float)
    return (v @ _HAT).reshape(*v.shape, 3)


def exp(v: Floats) -> Floats:
    """Rotation (..., 3, 3) by the rotation vector v (..., 3) [rad] (Rodrigues).

    I + sin(a)/a hat(v) + 2 (sin(a/2)/a)^2 (v v^T - a^2 I), a = |v|.
    """
    v = np.asarray(v, dtype=float)
    angle2 = np.einsum("...i,...i->...", v, v)
    angle = np.sqrt(angle2) / np.pi
    a, b = np.sinc(angle), 0.5 * np.sinc(0.5 * angle) ** 2
    R = a[..., None, None] * hat(v) + (b[..., None] * v)[..., None] * v[..., None, :]
    diagonal = np.einsum("...ii->...i", R)  # a view
    diagonal += (1.0 - b * angle2)[..., None]
    return R


def log(rotation: Floats) -> Floats:
    """Rotation vector (..., 3) [rad] of a rotation (..., 3, 3), angle in [0, pi].

    Below 120 degrees sine and cosine of the angle are enough; beyond, the unit quaternion keeps all digits up
    to and at the angle pi.
    """
    m = np.asarray(rotation, dtype=float)
    trace = np.einsum("...ii->...", m)
    axial = m[..., _AXIAL_ROW, _AXIAL_COLUMN] - m[..., _AXIAL_COLUMN, _AXIAL_ROW]
    sine = 0.5 * np.sqrt(np.einsum("...i,...i->...", axial, axial))
    angle = np.arctan2(sine, 0.5 * (trace - 1.0))
    small = sine < _SMALL_ANGLE
    factor = np.where(small, 0.5 + sine**2 / 12.0, 0.5 * angle / np.where(small, 1.0, sine))
    vector = np.asarray(factor[..., None] * axial)
    far = trace <= 0.0
    if np.any(far):
        vector[far] = _log_by_quaternion(m[far], trace[far], axial[far])
    return vector


def _log_by_quaternion(m: Floats, trace: Floats, axial: Floats) -> Floats:
    """Rotation vectors (n, 3) of rotations (n, 3, 3)."""
    # Of the four equivalent quaternion formulas, take for each rotation the one with the largest divisor.
    outer = np.empty((len(m), 4, 4))
    outer[:, 0, 0] = 1.0 + trace
    outer[:, 0, 1:] = outer[:, 1:, 0] = axial
    outer[:, 1:, 1:] = m + np.swapaxes(m, -1, -2) + (1.0 - trace)[:, None, None] * np.eye(3)
    best = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)[:, None, None]
    quaternion = np.take_along_axis(outer, best, axis=-2)[:, 0]
    quaternion = quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True)
    quaternion = np.where(quaternion[:, :1] < 0.0, -quaternion, quaternion)
    sine = np.linalg.norm(quaternion[:, 1:], axis=-1, keepdims=True)
    return 2.0 * np.arctan2(sine, quaternion[:, :1]) / sine * quaternion[:, 1:]


@dataclass(frozen=True)
class SectionRotation:
    """Polar rotation of a section and what its variation needs.

    A = sum_k d_k W_k^T, R = polar(A), V = A R^T (symmetric), G = tr(V) I - V, and the spin of R is
    dw = G^-1 sum_k (R W_k) x dd_k. A has rank 2; the third singular direction follows from det R = 1.
    """

    R: Floats  # (..., 3, 3)
    V: Floats  # (..., 3, 3) [m4]
    G_inverse: Floats  # (..., 3, 3) [1/m4]
    RW: Floats  # (..., directors, 3) [m4], the weights W_k turned with the section

    def spin(self) -> Floats:
        """dw/dd_k as (..., 3, directors, 3) [-]: dw = sum_k spin[:, k, :] dd_k."""
        return np.swapaxes(self.G_inverse[..., None, :, :] @ hat(self.RW), -3, -2)

    def couple(self, M: Floats) -> Floats:
        """Generalised forces (..., directors, 3) of moments M (..., 3) [N m]: Q_k = mu x (R W_k).

        mu = G^-1 M; the power sum_k Q_k . dd_k is M . dw.
        """
        mu = (self.G_inverse @ M[..., None])[..., 0]
        return self.RW @ np.swapaxes(hat(mu), -1, -2)

    def couple_tangent(self, M: Floats, dM: Floats | float, dw: Floats) -> Floats:
        """Change of `couple` (..., 3 directors, 3 directors), by row and column the directors' components.

            dmu = G^-1 (dM - dG mu),   dG = tr(dV) I - dV,   dV = sum_k dd_k (R W_k)^T - V hat(dw).

        Parameters
        ----------
        M : moments (..., 3) [N m]
        dM : their change with the directors (..., 3, 3 directors); 0.0 for moments fixed in space
        dw : the spin, reshaped to (..., 3, 3 directors)
        """
        RW = self.RW
        *lead, directors, _ = RW.shape
        mu = (self.G_inverse @ M[..., None])[..., 0]
        along = np.eye(3)[:, None] * (RW @ mu[..., None])[..., None, :, :]
        dV_mu = along.reshape(*lead, 3, 3 * directors) + self.V @ hat(mu) @ dw
        # tr(dV) = sum_k RW_k . dd_k: the trace of the symmetric V times a skew matrix is zero.
        dG_mu = mu[..., None] * RW.reshape(*lead, 1, 3 * directors) - dV_mu
        dmu = self.G_inverse @ (dM - dG_mu)
        # Q_l = mu x RW_l, RW_l turns with dw.
        hat_RW = hat(RW)
        dQ = -hat_RW @ dmu[..., None, :, :] - hat(mu)[..., None, :, :] @ hat_RW @ dw[..., None, :, :]
        return dQ.reshape(*lead, 3 * directors, 3 * directors)


def section_rotation(d: Floats, W: Floats) -> SectionRotation:
    """Polar rotation of the directors d (..., directors, 3) against the reference weights W (same shape)
    [m4].

    W_k = sum_b (int phi_k s_b dA) E_b with the section coordinates s = (y, z) and the reference directors
    E_y, E_z: the same least-squares rotation of the section as in the 3-D solid, so that moments on both are
    conjugate to the same spin.
    """
    A = np.swapaxes(d, -1, -2) @ W
    left, singular, right = np.linalg.svd(A)
    # The third singular value is zero, so the sign of the third direction is free: take det R = 1.
    left[..., :, 2] *= np.sign(np.linalg.det(left @ right))[..., None]
    singular[..., 2] = 0.0
    left_T = np.swapaxes(left, -1, -2)
    R = left @ right
    V = (left * singular[..., None, :]) @ left_T
    moment = np.sum(singular, axis=-1, keepdims=True) - singular  # eigenvalues of G, same directions
    G_inverse = (left / moment[..., None, :]) @ left_T
    return SectionRotation(R, V, G_inverse, W @ np.swapaxes(R, -1, -2))
