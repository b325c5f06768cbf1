"""Elastica: inextensible, shear-free cantilever under a dead tip force, transverse or axial (buckled).

Symbols
-------
theta   angle of the tangent, tip value theta_tip, [rad]
alpha   sqrt(P L^2/EI), [-]
m       parameter of the elliptic integrals, (1 + sin theta_tip)/2; buckled: sin^2(theta_tip/2)
beta    pi/2 - theta_tip
"""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, asin, cos, exp, expm1, log, pi, sin, sqrt

import numpy as np
from scipy.special import elliprd, elliprf

from reference.root import bracketed_root

# Below this load the elliptic integrals lose digits of u ~ load^2/15 by cancellation.
LIGHT_LOAD = 0.3


@dataclass(frozen=True)
class ElasticaTip:
    """Tip of the elastica: `u` shortening along the rod and `w` deflection, both over L; `angle` [rad]."""

    u: float
    w: float
    angle: float


def _alpha(beta: float) -> tuple[float, float]:
    """Return alpha and E(m) - E(phi_1, m) for a tip angle pi/2 - beta.

    alpha = K(m) - F(phi_1, m), sin^2 phi_1 = 1/(2m), written as F(psi, m) with tan psi tan phi_1 =
    1/sqrt(1 - m) (addition theorem); likewise E(m) - E(phi_1, m) = E(psi, m) - m sin(phi_1) sin(psi).
    Carlson's forms F = x R_F, E = x R_F - (m/3) x^3 R_D, x = sin psi, take 1 - m itself and so stay exact as
    m -> 1.
    """
    m1 = sin(beta / 2) ** 2  # 1 - m
    m = 1 - m1
    x2 = cos(beta) / (m1 + cos(beta))  # sin^2 psi, from tan^2 psi = sin(theta_tip)/(1 - m)
    cosine2 = m1 / (m1 + cos(beta))
    x, delta2 = sqrt(x2), cosine2 + m1 * x2
    first = x * float(elliprf(cosine2, delta2, 1.0))
    second = first - m / 3 * x**3 * float(elliprd(cosine2, delta2, 1.0))
    return first, second - sqrt(m / 2) * x


def _light(P: float) -> tuple[float, float, float]:
    """Return u, w, angle by quadrature in t, sin theta = eps (1 - t^2), which cancels nowhere at small loads.

    ds = (sqrt(2 eps)/alpha) dt/cos theta, hence alpha = sqrt(2 eps) int dt/cos theta and
    u = (sqrt(2 eps)/alpha) int (1 - cos theta)/cos theta dt, w the same with sin theta/cos theta.
    """
    t, weight = np.polynomial.legendre.leggauss(30)
    t, weight = (t + 1) / 2, weight / 2

    def angles(eps: float):
        sine = eps * (1 - t * t)
        return sine, np.sqrt(1 - sine**2)

    def gap(eps: float) -> float:
        return 2 * eps * float(weight @ (1 / angles(eps)[1])) ** 2 - P

    eps = bracketed_root(gap, 0.0, P)  # theta_tip < P L^2/(2 EI)
    sine, cosine = angles(eps)
    length = sqrt(2 * eps) / sqrt(P)
    u = length * float(weight @ (sine**2 / (1 + cosine) / cosine))
    return u, length * float(weight @ (sine / cosine)), asin(eps)


def elastica_tip_force(load: float) -> ElasticaTip:
    """Tip displacement and angle of a cantilever elastica under a dead transverse tip force.

    EI theta'' = -P cos theta integrates once to EI theta'^2/2 = P (sin theta_tip - sin theta), hence
    alpha = K(m) - F(phi_1, m),  w/L = 1 - (2/alpha)[E(m) - E(phi_1, m)],
    u/L = 1 - sqrt(2 sin theta_tip)/alpha.

    Parameters
    ----------
    load : P L^2/EI [-], any sign

    Returns
    -------
    ElasticaTip (u >= 0 shortens the rod; w and angle have the sign of the load)

    Notes
    -----
    Bisshopp and Drucker 1945; Mattiasson 1981. Relative accuracy 1e-12 at any load up to some 1e5.
    """
    P = abs(load)
    if P == 0:
        return ElasticaTip(0.0, 0.0, 0.0)
    if P < LIGHT_LOAD:
        u, w, angle = _light(P)
    else:
        # beta decays like exp(-alpha): solve for its logarithm.
        def gap(x: float) -> float:
            return log(_alpha(exp(x))[0] / sqrt(P))

        low, high = -320.0, log(pi / 2 - 1e-3)
        if gap(low) < 0:
            raise ValueError(f"load P L^2/EI = {P:.4g} is beyond the range of double precision")
        beta = exp(bracketed_root(gap, low, high))
        alpha, difference = _alpha(beta)
        w = 1 - 2 / alpha * difference
        u = 1 - sqrt(2 * cos(beta)) / alpha
        angle = pi / 2 - beta
    sign = 1.0 if load > 0 else -1.0
    return ElasticaTip(u, sign * w, sign * angle)


@dataclass(frozen=True)
class BuckledTip:
    """Tip of the buckled column: position `x` along the unbent axis and `y` across, over L; `angle` [rad]."""

    x: float
    y: float
    angle: float


def buckled_tip(load_ratio: float) -> BuckledTip:
    """Tip of a clamped-free elastica under a dead axial compression k P_E, P_E = pi^2 EI/(4 L^2).

    K(m) = (pi/2) sqrt(k), m = sin^2(angle/2); x/L = 2 E(m)/K(m) - 1, y/L = 2 sqrt(m)/K(m).

    Parameters
    ----------
    load_ratio : k [-]; up to 1 the column is straight

    Returns
    -------
    BuckledTip of the branch with y > 0 and one quarter wave (x < 0: the tip has passed the clamp)

    Raises
    ------
    ValueError beyond k = 231, where 1 - m leaves double precision.

    Notes
    -----
    EI theta'' = -P sin theta; Love, Treatise, art. 263; Timoshenko and Gere, art. 2.7. K and E of 1 - m by
    Carlson's forms R_F, R_D, exact as m -> 1: 1e-12 from k = 1 + 1e-8 on. A clamped-guided or pinned-pinned
    column consists of two quarter waves, a clamped-clamped one of four, each of this shape:
    `elastica_shortening`.
    """
    if load_ratio <= 1:
        return BuckledTip(1.0, 0.0, 0.0)
    K = pi / 2 * sqrt(load_ratio)

    def gap(x: float) -> float:
        return float(elliprf(0.0, exp(x), 1.0)) - K

    low = -45.0
    if gap(low) < 0:
        raise ValueError(f"load ratio {load_ratio:.4g} is beyond the range of double precision")
    m1 = exp(bracketed_root(gap, low, 0.0, absolute=1e-16))
    m = -expm1(log(m1))
    # E = K - (m/3) R_D(0, 1 - m, 1)
    return BuckledTip(
        x=1 - 2 * m / 3 * float(elliprd(0.0, m1, 1.0)) / K, y=2 * sqrt(m) / K, angle=2 * acos(sqrt(m1))
    )


def elastica_shortening(load_ratio: float) -> float:
    """Approach of the ends of a buckled elastica along its axis, over L, at the load k P_E.

    2 (1 - E(m)/K(m)), K(m) = (pi/2) sqrt(k), in the first mode of a column that is clamped-free,
    clamped-guided, pinned-pinned or clamped-clamped, P_E being its own Euler load. load_ratio k [-]; zero up
    to 1, slope 2 from there. Love, art. 263.
    """
    return 1 - buckled_tip(load_ratio).x


def elastica_closing_ratio() -> float:
    """Load over Euler's load at which the two ends of a buckled elastica meet: P/P_E = 2.18338.

    2 E(m) = K(m), m = 0.826115 (angle at the ends 130.71 degrees), for a pinned-pinned or clamped-clamped
    column. Love, art. 263; Timoshenko and Gere, art. 2.7.
    """
    return bracketed_root(lambda k: buckled_tip(k).x, 2.0, 3.0)
