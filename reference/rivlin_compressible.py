"""Flexure and torsion of compressible rubber: Rivlin's deformations with an unknown radius function.

Symbols: `x` the one coordinate the radius depends on (across the block or along the radius) [m], `r`(x) the
deformed radius [m], `P` first Piola-Kirchhoff stress in the cylindrical frames [Pa].
Both families keep their form in every isotropic law; only r solves an equation, collocated at Chebyshev
points (spectral: 24 reach rounding). Ogden, Non-linear Elastic Deformations (1984), sections 5.2 and 5.3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.invariant_laws import COMPLEX_STEP, Field, InvariantLaw

Array = NDArray[np.float64]

POINTS = 24
STEP = 1e-10  # of the radius: Newton's method then has converged quadratically to rounding
ROUNDING = 20 * float(np.finfo(float).eps)
RESIDUAL = 1e-6  # of the stress scale, before that last step
MAX_ITERATIONS = 40


@dataclass(frozen=True, eq=False)
class RadialSolution:
    """Deformed radius at the collocation points, couple and axial force.

    `x`, `radius` (n,) [m]; `moment` [N m], by width [N] in flexure; `axial_force` [N], zero in flexure.
    """

    x: Array
    radius: Array
    moment: float
    axial_force: float

    def radius_at(self, x: Array) -> Array:
        """Deformed radius [m] at any x, by the interpolating polynomial."""
        n = len(self.x)
        weight = (-1.0) ** np.arange(n)
        weight[[0, -1]] /= 2
        gap = np.asarray(x, float)[..., None] - self.x
        hit = np.abs(gap) < 1e-14 * np.ptp(self.x)
        share = weight / np.where(hit, 1.0, gap)
        share = np.where(hit.any(-1, keepdims=True), hit.astype(float), share)
        return share @ self.radius / share.sum(-1)


def flexure_compressible(law: InvariantLaw, curvature: float, thickness: float) -> RadialSolution:
    """Plane strain flexure: d P_r/dx = k P_t, P_r = 0 on both faces, F = diag(r', k r, 1).

    `curvature` k [1/m] and `thickness` [m] as in `rivlin.flexure_of_block`; x runs from -h/2 to h/2.
    M = int P_t r dx by width.

    Raises
    ------
    ValueError
        When Newton's method does not reach an equilibrium.
    """
    x, D, weight = _chebyshev(-thickness / 2, thickness / 2)

    # The unknown is r^2: linear in x without change of volume, so a large bulk modulus amplifies no error.
    def stress(square: Field) -> Field:
        r = np.sqrt(square)
        F = np.zeros((len(x), 3, 3), r.dtype)
        F[:, 0, 0], F[:, 1, 1], F[:, 2, 2] = D @ square / (2 * r), curvature * r, 1.0
        return law.stress(F)

    def residual(square: Field) -> Field:
        P = stress(square)
        out = D @ P[:, 0, 0] - curvature * P[:, 1, 1]
        out[[0, -1]] = P[[0, -1], 0, 0] / thickness
        return out

    # incompressible start: k^2 r_i r_o = 1
    start = 2 * x / curvature + np.sqrt(1 + (curvature * thickness) ** 2) / curvature**2
    square = _newton(residual, start, law, thickness)
    r = np.sqrt(square)
    return RadialSolution(x, r, float(weight @ (stress(square)[:, 1, 1] * r)), 0.0)


def torsion_compressible(
    law: InvariantLaw, twist: float, radius: float, stretch: float = 1.0
) -> RadialSolution:
    """Twisted and stretched cylinder with a free side, (x P_r)' = P_t + x tau P_tz.

    F = [[r', 0, 0], [0, r/x, r tau], [0, 0, lambda]]; `twist`, `radius`, `stretch` as in
    `rivlin.torsion_of_cylinder`. M = 2 pi int r P_tz x dx, N = 2 pi int P_zz x dx.

    Raises
    ------
    ValueError
        When Newton's method does not reach an equilibrium.
    """
    x, D, weight = _chebyshev(0.0, radius)

    def stress(r: Field) -> Field:
        slope = D @ r
        F = np.zeros((len(x), 3, 3), r.dtype)
        F[:, 0, 0], F[:, 1, 2], F[:, 2, 2] = slope, twist * r, stretch
        F[0, 1, 1], F[1:, 1, 1] = slope[0], r[1:] / x[1:]
        return law.stress(F)

    def residual(r: Field) -> Field:
        P = stress(r)
        out = (D @ (x * P[:, 0, 0]) - P[:, 1, 1] - twist * x * P[:, 1, 2]) / radius
        out[-1] = P[-1, 0, 0] / radius
        out[0] = (
            r[0] * law.stress(np.diag([1.01, 1.0, 1.0]))[0, 0] / radius**2
        )  # r(0) = 0, in units of stress
        return out

    r = _newton(residual, x / np.sqrt(stretch), law, radius)
    P = stress(r)
    return RadialSolution(
        x, r, float(2 * np.pi * weight @ (r * P[:, 1, 2] * x)), float(2 * np.pi * weight @ (P[:, 2, 2] * x))
    )


def _newton(residual: Callable[[Field], Field], start: Array, law: InvariantLaw, length: float) -> Array:
    """Zero of `residual` [Pa/m] with the exact Jacobian by complex steps."""
    n = len(start)
    A = law.tangent(np.eye(3))
    scale = float(np.abs(A).max()) / length
    # Near incompressibility rounding of the pressure moves the radius by eps times the ratio of the moduli.
    quiet = max(STEP, ROUNDING * float(np.abs(A).max() / A[0, 1, 0, 1]))
    r = start
    with np.errstate(all="ignore"):  # a radius without meaning is found below
        for _ in range(MAX_ITERATIONS):
            steps = [np.imag(residual(r + 1j * COMPLEX_STEP * e)) / COMPLEX_STEP for e in np.eye(n)]
            jacobian, right = np.array(steps).T, -residual(r)
            if not (np.all(np.isfinite(jacobian)) and np.all(np.isfinite(right))):
                break
            try:
                dr = np.linalg.solve(jacobian, right)
            except np.linalg.LinAlgError:
                break
            r = r + dr
            if np.abs(dr).max() < quiet * np.abs(r).max() and np.abs(right).max() < RESIDUAL * scale:
                return r
    raise ValueError("the radius of the bent or twisted rubber was not found; try a smaller deformation.")


def _chebyshev(low: float, high: float) -> tuple[Array, Array, Array]:
    """Chebyshev points (n,), differentiation matrix (n, n) and Clenshaw-Curtis weights (n,) on [low, high].

    Trefethen, Spectral Methods in MATLAB (2000), chapters 6 and 12.
    """
    n = POINTS
    t = -np.cos(np.pi * np.arange(n) / (n - 1))
    c = np.ones(n)
    c[[0, -1]] = 2
    c *= (-1.0) ** np.arange(n)
    gap = t[:, None] - t + np.eye(n)
    D = np.outer(c, 1 / c) / gap
    D -= np.diag(D.sum(axis=1))
    powers = np.polynomial.chebyshev.chebvander(t, n - 1)
    even = np.arange(n) % 2 == 0
    moments = np.where(even, 2 / (1.0 - np.where(even, np.arange(n), 0) ** 2), 0.0)
    weight = np.linalg.solve(powers.T, moments)
    half = (high - low) / 2
    return low + half * (1 + t), D / half, np.asarray(weight * half, float)
