"""Uniaxial stretch with free lateral contraction, and what a constrained section does to the stiffness.

Symbols
-------
lambda_   axial stretch, [-]
f         force over reference area and Young's (or shear) modulus, [-]
"""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, acosh, cos, cosh, sqrt

from reference.root import bracketed_root


@dataclass(frozen=True)
class Stretch:
    """Uniaxial state: axial and lateral stretch [-]."""

    axial: float
    lateral: float


def uniaxial_saint_venant_kirchhoff(
    force: float, young_modulus: float, poisson_ratio: float, area: float
) -> Stretch:
    """Stretch of a Saint Venant-Kirchhoff rod under a dead axial force, sides free.

    The lateral stress vanishes, so S_xx = E (lambda^2 - 1)/2 and force = A lambda S_xx:
    lambda^3 - lambda = 2 f, f = F/(E A). The largest root: (2/sqrt 3) cos(arccos(3 sqrt 3 f)/3), with cosh
    for 3 sqrt 3 f > 1. Lateral stretch^2 = 1 - nu (lambda^2 - 1).

    Parameters
    ----------
    force : [N], tension positive
    young_modulus : [Pa]
    poisson_ratio : [-]
    area : [m2], reference

    Returns
    -------
    Stretch

    Raises
    ------
    ValueError in compression beyond f = -1/(3 sqrt 3), where the law has no equilibrium (lambda = 1/sqrt 3),
    and in tension where the section has shrunk to nothing.
    """
    x = 3 * sqrt(3) * force / (young_modulus * area)
    if x < -1:
        raise ValueError(f"no equilibrium: force {force:.6g} N is below -E A/(3 sqrt 3)")
    axial = 2 / sqrt(3) * (cos(acos(x) / 3) if x <= 1 else cosh(acosh(x) / 3))
    square = 1 - poisson_ratio * (axial**2 - 1)
    if square <= 0:
        raise ValueError(f"the section shrinks to nothing before axial stretch {axial:.6g}")
    return Stretch(axial, sqrt(square))


def uniaxial_neo_hookean(force: float, shear_modulus: float, area: float) -> Stretch:
    """Stretch of an incompressible neo-Hookean rod under a dead axial force, sides free.

    force = mu A (lambda - lambda^-2), i.e. lambda^3 - f lambda^2 - 1 = 0, one positive root; lateral stretch
    lambda^-1/2. mu = 9e5 Pa, A = .01 m2, 9500 N: lambda = 1.5 exactly. Treloar, Physics of Rubber Elasticity.
    Returns Stretch.
    """
    f = force / (shear_modulus * area)
    low, high = (1.0, 1.0 + f) if f >= 0 else (0.0, 1.0)
    root = bracketed_root(lambda x: x**3 - f * x * x - 1, low, high)
    return Stretch(root, 1 / sqrt(root))


def full_hooke_locking_factor(poisson_ratio: float) -> float:
    """Bending stiffness of the fully continuum-based 2-node element over EI: (1 - nu)/((1 + nu)(1 - 2 nu)).

    A section displacement linear in y and z cannot follow the anticlastic shape, so lateral strain is zero at
    every fibre and the modulus is the oedometric lambda + 2 mu. 1.3462, 3.7931, 17.114 at nu = .3, .45, .49.
    Sopanen and Mikkola 2003; derived here.
    """
    nu = poisson_ratio
    return (1 - nu) / ((1 + nu) * (1 - 2 * nu))
