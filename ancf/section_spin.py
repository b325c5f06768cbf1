r"""Couples and turning forces on many sections at once, in the axes of each section.

Moments on a section see two vectors only (fused_load.py, rotation.py): with the reference axes E_y, E_z and
W_k = sum_b I_kb E_b they are b_y, b_z = sum_k d_k I_k. In the axes F = (q_y, q_z, n) that turn with the
section they have the symmetric components S, and no third one:

    d = |b_y x b_z|,  t = tr S,  S = (B B^T + d I)/t,  q = S^-1 b,  n = b_y x b_z/d,  G^-1 = diag(S/d, 1/t)

(B B^T the products of b_y, b_z; S/d is the inverse of adj S). Components of db_y, db_z in these axes give the
spin and the changes of S,

    dw = G^-1 (b_z,n   -b_y,n   b_y,z - b_z,y),    dS_yy = b_y,y + S_yz dw_n,    dS_zz = b_z,z - S_yz dw_n,
    dS_yz = (S_zz b_y,z + S_yy b_z,y)/t

(written without the d of db). A couple M with mu = G^-1 M = (m_y, m_z, m_n) is carried by

    Q_y = mu x q_y = m_n q_z - m_z n,   Q_z = mu x q_z = m_y n - m_n q_y.

With Om (3, 6) for dw by (db_y, db_z), and dM = A dw in the section's axes (dM the change of the components),

    dQ = U^T Om + Om^T T,   T = A Om - X,

U : what turns with the section: row w is e_w x Q, so row y (m_z q_z + m_n n, -m_y q_z), row z
    (-m_z q_y, m_y q_y + m_n n), row n (-m_n q_y, -m_n q_z)
X : dG mu, (m_y dS_zz - m_z dS_yz, m_z dS_yy - m_y dS_yz, m_n (b_y,y + b_z,z))
A : of a couple fixed in space hat(M), of one that turns with its section 0.

All of Om, U and X are linear in S/d, 1/t, mu and products of m_y, m_z with S/t: `_TANGENT` holds the factors.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TWICE_ROUND = np.array([0, 1, 2, 0, 1])  # components of a, so that a[1:4], a[2:5] are its cycles
Y, Z, N = 0, 1, 2


def _couple_factors() -> Floats:
    """Q (y, z; components) by mu."""
    Q = np.zeros((3, 2, 3))
    Q[N, Y, Z], Q[Z, Y, N] = 1.0, -1.0
    Q[Y, Z, N], Q[N, Z, Y] = 1.0, -1.0
    return Q.reshape(3, 6)


def _spin_factors() -> Floats:
    """Om (row; y, z; components) by S/d (yy, yz, zy, zz) and 1/t."""
    Om = np.zeros((5, 3, 2, 3))
    for row in (Y, Z):
        Om[2 * row + Y, row, Z, N] = 1.0
        Om[2 * row + Z, row, Y, N] = -1.0
    Om[4, N, Y, Z], Om[4, N, Z, Y] = 1.0, -1.0
    return Om.reshape(5, 18)


def _tangent_factors() -> Floats:
    """U, Om and -X by S/d (4), 1/t, mu (3), and m_y, m_z times S/t (2, 4)."""
    factors = np.zeros((16, 3, 3, 2, 3))
    factors[:5, 1] = _spin_factors().reshape(5, 3, 2, 3)
    U, minus_X = factors[:, 0], factors[:, 2]
    m_y, m_z, m_n = 5, 6, 7
    U[m_z, Y, Y, Z], U[m_n, Y, Y, N], U[m_y, Y, Z, Z] = 1.0, 1.0, -1.0
    U[m_z, Z, Y, Y], U[m_y, Z, Z, Y], U[m_n, Z, Z, N] = -1.0, 1.0, 1.0
    U[m_n, N, Y, Y], U[m_n, N, Z, Z] = -1.0, -1.0
    minus_X[m_n, N, Y, Y] = minus_X[m_n, N, Z, Z] = -1.0
    for m, row, own, sign in ((m_y, Y, Z, -1.0), (m_z, Z, Y, 1.0)):
        by_S = 8 + 4 * (m - m_y)  # m times S_yy/t, S_yz/t, S_zy/t, S_zz/t
        # - m dS_own,own; dw_n = (b_y,z - b_z,y)/t
        minus_X[m, row, own, own] -= 1.0
        minus_X[by_S + 1, row, Y, Z] -= sign
        minus_X[by_S + 1, row, Z, Y] += sign
        # + m dS_yz in the other row
        minus_X[by_S + 3, 1 - row, Y, Z] += 1.0
        minus_X[by_S, 1 - row, Z, Y] += 1.0
    return factors.reshape(16, 54)


_COUPLE, _SPIN, _TANGENT = _couple_factors(), _spin_factors(), _tangent_factors()


def section_map(N: Floats, W: Floats) -> tuple[Floats, Floats]:
    """The map (..., 2, nodal) to b_y, b_z from nodal vectors, and the axes E (..., 3, 3) as rows y, z, x.

    N : (..., directors, nodal) to the directors;  W : (..., directors, 3) weights of the section rotation
    """
    # Any orthonormal axes in the plane of the weights would do; in the principal ones S is nearly diagonal.
    _, _, axes = np.linalg.svd(W)
    E = axes[..., :2, :]
    E = np.concatenate([E, np.cross(E[..., 0, :], E[..., 1, :])[..., None, :]], axis=-2)
    return E[..., :2, :] @ np.swapaxes(W, -1, -2) @ N, E


def cross(a: Floats, b: Floats) -> Floats:
    """Products a x b (3, p) of vectors (3, p)."""
    a, b = a.take(TWICE_ROUND, 0), b.take(TWICE_ROUND, 0)
    return a[1:4] * b[2:5] - a[2:5] * b[1:4]


@dataclass(frozen=True)
class SectionAxes:
    """Axes and stretch of the vectors b of p sections; vectors are (3, p), the section last."""

    F: Floats  # (3, 3, p) q_y, q_z, n
    factors: Floats  # (5, p) S/d (yy, yz, zy, zz) and 1/t
    S_t: Floats  # (4, p) S/t

    @classmethod
    def of(cls, b: Floats) -> SectionAxes:
        """Of b (p, 2, 3); not finite where a section has collapsed to a line."""
        count = len(b)
        v = np.empty((3, 3, count))  # b_y, b_z, b_y x b_z
        v[:2] = b.transpose(1, 2, 0)
        v[2] = cross(v[0], v[1])
        squares = np.add.reduce(v * v, 1)
        d = np.sqrt(squares[2])
        S = np.empty((4, count))  # times t
        np.add(squares[0], d, out=S[0])
        np.add(squares[1], d, out=S[3])
        S[1:3] = np.add.reduce(v[0] * v[1], 0)
        factors = np.empty((5, count))
        per_t, per_d = np.divide(1.0, np.sqrt(S[0] + S[3]), out=factors[4]), 1.0 / d
        S *= per_t
        S_d = np.multiply(S, per_d, out=factors[:4])
        F = np.empty((3, 3, count))
        np.multiply(S_d[::-3, None], v[:2], out=F[:2])
        F[:2] -= S_d[1] * v[1::-1]
        np.multiply(per_d, v[2], out=F[2])
        return cls(F, factors, S * per_t)

    def local(self, a: Floats) -> Floats:
        """Components (3, p) in the axes of a vector a (3,)."""
        return a @ self.F

    def vector(self, f: Floats) -> Floats:
        """Vectors (p, 3) in space from their components f (3, p) in the axes."""
        return np.add.reduce(f[:, None] * self.F, 0).T

    def vector_change(self, hat_f: Floats) -> Floats:
        """Change (p, 3, 2, 3) of `vector` with b, df = dw x f, by hat(f) (p, 3, 3) in the axes."""
        spin = (self.factors.T @ _SPIN).reshape(-1, 6, 3) @ self.rows
        turned = np.ascontiguousarray(self.F.transpose(2, 1, 0)) @ hat_f  # columns q_y, q_z, n, times f
        return (turned @ -spin.reshape(-1, 3, 6)).reshape(-1, 3, 2, 3)

    def mu(self, M: Floats) -> Floats:
        """mu (3, p) of couples M (3, p), both in the axes."""
        mu = np.empty_like(M)
        np.add.reduce(self.factors[:4].reshape(2, 2, -1) * M[:2], 1, out=mu[:2])
        np.multiply(self.factors[4], M[2], out=mu[2])
        return mu

    def couple(self, mu: Floats) -> Floats:
        """Generalised forces (p, 2, 3) on b_y, b_z, in space."""
        return (mu.T @ _COUPLE).reshape(-1, 2, 3) @ self.rows

    def couple_tangent(self, mu: Floats, A: Floats | None) -> Floats:
        """Change (p, 6, 6) of `couple` with b; A (p, 3, 3), None for a couple that turns with it."""
        factors = np.empty((16, mu.shape[1]))
        factors[:5] = self.factors
        factors[5:8] = mu
        np.multiply(mu[:2, None], self.S_t, out=factors[8:].reshape(2, 4, -1))
        rows = (factors.T @ _TANGENT).reshape(-1, 9, 6)
        if A is not None:
            rows[:, 6:] += A @ rows[:, 3:6]
        rows = (rows.reshape(-1, 18, 3) @ self.rows).reshape(-1, 9, 6)
        return np.swapaxes(rows[:, :6], 1, 2) @ rows[:, 3:]

    @cached_property
    def rows(self) -> Floats:
        """Axes (p, 3, 3) as rows, the section first."""
        return np.ascontiguousarray(self.F.transpose(2, 0, 1))

    def rotation(self, E: Floats) -> Floats:
        """Rotation R (p, 3, 3) of the sections from their reference axes E (p, 3, 3), rows."""
        return np.swapaxes(self.rows, -1, -2) @ E
