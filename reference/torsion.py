"""Torsion of straight rods: Saint-Venant constants and the twist angle.

Symbols
-------
J_t   torsion constant, torque = G J_t times twist per length, [m4]
I_p   polar moment I_y + I_z; J_t <= I_p, equal for circles only, [m4]
"""

from __future__ import annotations

from math import pi, tanh


def twist_angle(moment: float, length: float, GJ: float) -> float:
    """Angle M L/(G J) [rad] between the ends of a rod in torsion; moment [N m], length [m], GJ [N m2]."""
    return moment * length / GJ


def torsion_constant_circle(radius: float, inner_radius: float = 0.0) -> float:
    """J = pi (R^4 - r^4)/2 [m4], circle or annulus, equal to I_p (no warping). Radii [m]."""
    return pi * (radius**4 - inner_radius**4) / 2


def torsion_constant_ellipse(semi_y: float, semi_z: float) -> float:
    """J = pi a^3 b^3/(a^2 + b^2) [m4], semi-axes a, b [m] (Saint-Venant 1855)."""
    a, b = semi_y, semi_z
    return pi * a**3 * b**3 / (a * a + b * b)


def torsion_constant_rectangle(side: float, other_side: float) -> float:
    """Torsion constant of a solid rectangle, sides [m], in either order.

    J = a b^3 [1/3 - (64 b/(pi^5 a)) sum_{n odd} tanh(n pi a/(2 b))/n^5], a >= b [m4]: square .140577 a^4,
    2:1 .228682 a b^3, thin strip a b^3/3.

    Notes
    -----
    Timoshenko and Goodier, Theory of Elasticity, art. 109, with sides 2a, 2b there. The series is cut at
    n = 399 and the tail added as int dn/(2 n^5): error below 1e-14.
    """
    a, b = max(side, other_side), min(side, other_side)
    last = 399
    total = sum(tanh(n * pi * a / (2 * b)) / n**5 for n in range(1, last + 1, 2))
    total += 1 / (8 * (last + 1) ** 4)
    return a * b**3 * (1 / 3 - 64 * b / (pi**5 * a) * total)


def torsion_constant_linear_section(I_y: float, I_z: float) -> float:
    """J = I_y + I_z [m4] of an element whose displacement is linear in y, z (plane section): 3243, 3333."""
    return I_y + I_z


def torsion_constant_bilinear_section(I_y: float, I_z: float) -> float:
    """J = 4 I_y I_z/(I_y + I_z) [m4] of a section that may warp by c y z, elements with a yz term.

    The energy (c - 1)^2 I_y + (c + 1)^2 I_z (I_y = int z^2 dA) is smallest at c = (I_y - I_z)/(I_y + I_z).
    Derived here; 2:1 rectangle .266667 a b^3 against the exact .228682.
    """
    return 4 * I_y * I_z / (I_y + I_z)
