"""Circular arch under a dead point force, a plane rod with extension and shear: equations and collocation.

The force in the rod is constant on either side of the load, so the angle alone has to be solved for:
EI theta'' = -(r' x n).z on the two parts, closed by the position of the far end. The path: `arch_path`.
Reissner 1972, ZAMP 23:795; collocation: Trefethen, Spectral Methods in MATLAB, ch. 6, 12, 13.

Symbols
-------
theta     angle of the section normal from x, [rad]
kappa_0   curvature of the unstressed arch, -opening/length, [1/m]
n         internal force, n on the left of the load and n - P d on its right, [N]
gamma     stretch of the axis in section axes, (1 + n_1/EA, n_2/GA), [-]
P, d      load and its fixed direction
z         unknowns: theta at the nodes of both parts, n (2), P; all in units of L, EI/L^2
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ends = Literal["clamped", "pinned"]


@dataclass(frozen=True)
class Arch:
    """Circular arch in the plane: length [m] along the arc, opening angle [rad], EI [N m2], EA, GA [N].

    Chord along x, crown towards +y. The dead force acts at `load_at` (fraction of the arc from the left end)
    and towards -y ("vertical") or the centre of the unstressed circle ("radial"); both are the same at the
    middle. `ends` are ("left", "right"), each clamped or pinned.
    """

    length: float
    opening: float
    EI: float
    EA: float
    GA: float
    load_at: float = 0.5
    direction: Literal["vertical", "radial"] = "vertical"
    ends: tuple[Ends, Ends] = ("clamped", "clamped")

    @classmethod
    def circle(
        cls, length: float, radius: float, opening: float, young_modulus: float, poisson_ratio: float
    ) -> Arch:
        """Clamped arch of round section, shear factor 1, force at the middle: A = pi R^2, I = pi R^4/4."""
        area = np.pi * radius**2
        shear = young_modulus / (2 * (1 + poisson_ratio)) * area
        return cls(length, opening, young_modulus * area * radius**2 / 4, young_modulus * area, shear)

    @property
    def symmetric(self) -> bool:
        """Whether arch and load have a plane of symmetry: then only the symmetric path is followed."""
        return self.load_at == 0.5 and self.ends[0] == self.ends[1]


class ArchEquations:
    """Residual, Jacobian and path tangent of an `Arch` on `intervals` Chebyshev intervals a part."""

    def __init__(self, arch: Arch, intervals: int) -> None:
        self.arch, self.N = arch, intervals
        self.lengths = np.array([arch.load_at, 1 - arch.load_at])
        D, self.x, weights = chebyshev(intervals)
        self.D = [D / h for h in self.lengths]
        self.weights = [h * weights for h in self.lengths]
        self.kappa0 = -arch.opening
        self.compliance = arch.EI / arch.length**2 / np.array([arch.EA, arch.GA])
        start = np.array([0.0, self.lengths[0]])
        self.reference = arch.opening / 2 - arch.opening * (start[:, None] + self.lengths[:, None] * self.x)
        self.chord = np.array([2 * np.sin(arch.opening / 2) / arch.opening, 0.0])
        tilt = self.reference[1, 0] if arch.direction == "radial" else 0.0
        self.d = np.array([np.sin(tilt), -np.cos(tilt)])
        self.start_position = self._left_end(self.unstressed())

    def unstressed(self) -> Array:
        """Unknowns of the unloaded arch."""
        return np.concatenate([self.reference.ravel(), np.zeros(3)])

    def slope(self, theta: Array, n: Array) -> tuple[Array, Array, Array]:
        """r' = R gamma (2, k) and its derivatives by theta (2, k) and n (2, 2, k)."""
        c, s = np.cos(theta), np.sin(theta)
        e, f = self.compliance
        n1, n2 = c * n[0] + s * n[1], -s * n[0] + c * n[1]
        g1, g2 = 1 + e * n1, f * n2
        r = np.array([c * g1 - s * g2, s * g1 + c * g2])
        # d gamma/d theta = (e n2, -f n1)
        by_theta = np.array([-r[1] + c * e * n2 + s * f * n1, r[0] + s * e * n2 - c * f * n1])
        by_n = np.array([[e * c * c + f * s * s, (e - f) * c * s], [(e - f) * c * s, e * s * s + f * c * c]])
        return r, by_theta, by_n

    def __call__(self, z: Array) -> tuple[Array, Array]:
        """Residual (2 N + 4,) and Jacobian (2 N + 4, 2 N + 5).

        theta'' + r' x n = 0 inside the parts; clamp theta = theta_0 or pin theta' = kappa_0; theta and theta'
        continuous at the load; int r' = chord.
        """
        m = self.N + 1
        theta, n_left, P = z[: 2 * m].reshape(2, m), z[2 * m : 2 * m + 2], z[-1]
        F, J = np.zeros(2 * m + 2), np.zeros((2 * m + 2, 2 * m + 3))
        force, load = slice(2 * m, 2 * m + 2), -1
        F[-2:] = -self.chord
        for k, n in enumerate((n_left, n_left - P * self.d)):
            D, own, w = self.D[k], slice(k * m, (k + 1) * m), self.weights[k]
            r, by_theta, by_n = self.slope(theta[k], n)
            F[own] = D @ D @ theta[k] + r[0] * n[1] - r[1] * n[0]
            J[own, own] = D @ D + np.diag(by_theta[0] * n[1] - by_theta[1] * n[0])
            J[own, force] = (by_n[0] * n[1] - by_n[1] * n[0] + np.array([-r[1], r[0]])).T
            F[-2:] += r @ w
            J[-2:, own] = by_theta * w
            J[-2:, force] += by_n @ w
            if k:
                J[own, load] = -J[own, force] @ self.d
                J[-2:, load] = -(by_n @ w) @ self.d
        for row, k, at, end in ((0, 0, 0, self.arch.ends[0]), (2 * m - 1, 1, -1, self.arch.ends[1])):
            J[row] = 0.0
            own = slice(k * m, (k + 1) * m)
            if end == "clamped":
                F[row] = theta[k, at] - self.reference[k, at]
                J[row, own.start if at == 0 else own.stop - 1] = 1.0
            else:
                F[row] = self.D[k][at] @ theta[k] - self.kappa0
                J[row, own] = self.D[k][at]
        J[m - 1 : m + 1] = 0.0
        F[m - 1] = theta[0, -1] - theta[1, 0]
        J[m - 1, m - 1], J[m - 1, m] = 1.0, -1.0
        F[m] = self.D[0][-1] @ theta[0] - self.D[1][0] @ theta[1]
        J[m, :m], J[m, m : 2 * m] = self.D[0][-1], -self.D[1][0]
        return F, J

    def _left_end(self, z: Array) -> Array:
        m = self.N + 1
        return self.slope(z[:m], z[2 * m : 2 * m + 2])[0] @ self.weights[0]

    def displacement(self, z: Array) -> float:
        """Displacement of the loaded point along the load, over the length."""
        return float((self._left_end(z) - self.start_position) @ self.d)

    def displacement_gradient(self, z: Array) -> Array:
        """Derivative of `displacement` by z."""
        m = self.N + 1
        _, by_theta, by_n = self.slope(z[:m], z[2 * m : 2 * m + 2])
        out = np.zeros_like(z)
        out[:m] = self.d @ by_theta * self.weights[0]
        out[2 * m : 2 * m + 2] = self.d @ (by_n @ self.weights[0])
        return out

    def symmetric_states(self) -> Array:
        """Basis (2 N + 5, N + 2) of the symmetric states: theta odd about the load, n_y = -P/2 left of it."""
        m = self.N + 1
        B = np.zeros((2 * m + 3, m + 1))
        k = np.arange(self.N)
        B[k, k], B[2 * m - 1 - k, k] = 1.0, -1.0
        B[2 * m, -2] = 1.0
        B[2 * m + 1 :, -1] = -0.5, 1.0
        return B

    def weight(self) -> Array:
        """Weights of the norm of z: the mean square of theta, and forces in units of 4 pi^2 EI/L^2."""
        return np.concatenate([*self.weights, np.full(3, (4 * np.pi**2) ** -2)])


def chebyshev(N: int) -> tuple[Array, Array, Array]:
    """Differentiation matrix, points and Clenshaw-Curtis weights on [0, 1]. Trefethen, ch. 6, 12."""
    k = np.arange(N + 1)
    x = (1 - np.cos(np.pi * k / N)) / 2
    c = np.where((k == 0) | (k == N), 2.0, 1.0) * (-1.0) ** k
    # x_i - x_j without cancellation
    gap = np.sin(np.pi * (k[:, None] + k) / (2 * N)) * np.sin(np.pi * (k[:, None] - k) / (2 * N))
    D = np.outer(c, 1 / c) / (gap + np.eye(N + 1))
    np.fill_diagonal(D, 0.0)
    D -= np.diag(D.sum(axis=1))
    # Exact for cos(j k pi/N), Chebyshev polynomials at the points, whose integral is 1/(1 - j^2) or 0.
    j = np.arange(N + 1)
    moments = np.where(j % 2 == 0, 1 / np.where(j == 1, 1, 1 - j.astype(float) ** 2), 0.0)
    weights = np.linalg.solve(np.cos(np.pi * np.outer(j, k) / N), moments)
    return D, x, weights
