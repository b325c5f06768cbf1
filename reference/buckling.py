"""Buckling loads of straight rods (inextensible, shear-free), and of a narrow cantilever sideways.

Symbols
-------
EI   bending stiffness about the axis of buckling, [N m2]
"""

from __future__ import annotations

from math import pi, sqrt, tan

from scipy.special import jv

from reference.root import bracketed_root


def euler_load(EI: float, length: float, ends: str = "clamped-free") -> float:
    """Critical axial force of a column, P = k EI/L^2 [N].

    k = pi^2/4 clamped-free, pi^2 pinned-pinned, 20.1907 clamped-pinned (x^2 with tan x = x), 4 pi^2
    clamped-clamped, pi^2 clamped-guided. EI [N m2], length [m]. Euler 1744; Timoshenko and Gere, ch. 2.
    """
    factors = {
        "clamped-free": pi**2 / 4,
        "pinned-pinned": pi**2,
        "clamped-pinned": bracketed_root(lambda x: x - tan(x), 4.4, 4.6) ** 2,
        "clamped-clamped": 4 * pi**2,
        "clamped-guided": pi**2,
    }
    if ends not in factors:
        raise ValueError(f"ends must be one of {', '.join(factors)}, got {ends!r}")
    return factors[ends] * EI / length**2


def self_weight_load(EI: float, length: float) -> float:
    """Critical weight per length of an upright clamped-free column, q = (9/4) j^2 EI/L^3 [N/m].

    EI phi'' + q (L - s) phi = 0 has the solution sqrt(x) J_{-1/3}((2/3) sqrt(q/EI) x^{3/2}), x = L - s (zero
    slope at x = 0), so j = 1.86635 is the first zero of J_{-1/3}: q L^3/EI = 7.83735. Greenhill 1881.
    """
    j = bracketed_root(lambda x: float(jv(-1 / 3, x)), 1.0, 3.0)
    return 9 / 4 * j**2 * EI / length**3


def lateral_buckling_load(EI: float, GJ: float, length: float) -> float:
    """Critical transverse tip force of a narrow cantilever, P = 4.0126 sqrt(EI GJ)/L^2 [N].

    EI is the weak (lateral) bending stiffness. The twist obeys beta'' + (P^2/(EI GJ)) x^2 beta = 0,
    x = L - s, solved by sqrt(x) J_{-1/4}(P x^2/(2 sqrt(EI GJ))), zero twist moment at the tip;
    P L^2/sqrt(EI GJ) is twice the first zero of J_{-1/4}. The force acts at the centroid; bending before
    buckling is neglected (weak/strong stiffness small). Michell 1899, Prandtl 1899; Timoshenko and Gere,
    art. 6.3.
    """
    j = bracketed_root(lambda x: float(jv(-1 / 4, x)), 1.0, 3.0)
    return 2 * j * sqrt(EI * GJ) / length**2
