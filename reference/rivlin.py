"""Rivlin's exact solutions for incompressible rubber: flexure of a block and torsion of a cylinder.

Symbols: `c10`, `c01` constants of Mooney and Rivlin [Pa], Psi = c10 (I1 - 3) + c01 (I2 - 3); mu = 2 (c10 +
c01); `k` angle of bending by length [1/m]; `h` thickness of the block [m]; `tau` twist by reference length
[1/m]; `a` reference radius [m]; `lambda_` axial stretch [-].

Sources: R. S. Rivlin, Large elastic deformations of isotropic materials V (flexure) and VI (torsion), Proc.
R. Soc. A 195 (1949) 463 and Phil. Trans. A 242 (1949) 173; R. W. Ogden, Non-linear Elastic Deformations
(1984), section 5.2. Derived again here. They hold for every law with the same energy of an isochoric
deformation, so also in the limit nu = 1/2 of the compressible ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asinh, exp, pi, sinh

from reference.root import bracketed_root


@dataclass(frozen=True)
class Flexure:
    """A block bent into a sector of a ring in plane strain: radii [m] and couple by width [N]."""

    inner_radius: float
    outer_radius: float
    moment: float


@dataclass(frozen=True)
class Torsion:
    """A twisted cylinder: couple [N m] and axial force [N, tension positive]."""

    moment: float
    axial_force: float


def flexure_of_block(curvature: float, thickness: float, c10: float, c01: float) -> Flexure:
    """Plane strain flexure by end couples alone, faces free of traction.

    With e = asinh(k h)/2 the hoop stretches of the faces are exp(-e) and exp(e), the radii these by k, and
    M = mu/(2 k^2) (sinh(4 e)/2 - 2 e) by width.

    Parameters
    ----------
    curvature : float
        Angle between two sections by their reference distance, k [1/m], positive.
    thickness : float
        [m], positive.
    c10, c01 : float
        [Pa]; only their sum counts, because I1 = I2 in plane strain.

    Raises
    ------
    ValueError
        For a curvature or a thickness that is not positive.

    Notes
    -----
    r dr = dX/k keeps the area, so the stretches are 1/(k r) and k r and r_o^2 - r_i^2 = 2 h/k. Radial
    equilibrium is d sigma_r = dW: no traction on both faces asks W(k r_i) = W(k r_o), k^2 r_i r_o = 1. The
    resultant force [r sigma_r] then vanishes and M = - int r sigma_r dr.
    Thin limit: M = mu h^3 k/3 = 4 mu I k, the plane strain modulus at nu = 1/2.
    """
    if not (curvature > 0 and thickness > 0):
        raise ValueError(f"curvature is {curvature} 1/m and thickness {thickness} m; both must be positive.")
    mu = 2 * (c10 + c01)
    e = asinh(curvature * thickness) / 2
    moment = mu / (2 * curvature**2) * (sinh(4 * e) / 2 - 2 * e)
    return Flexure(exp(-e) / curvature, exp(e) / curvature, moment)


def torsion_of_cylinder(twist: float, radius: float, c10: float, c01: float, stretch: float = 1.0) -> Torsion:
    """Couple and axial force that hold a cylinder at a twist and a stretch, its side free.

    M = pi a^4 tau (c10/lambda + c01/lambda^2),
    N = 2 pi a^2 (lambda - lambda^-2)(c10 + c01/lambda) - pi/2 a^4 tau^2 (c10 + 2 c01/lambda)/lambda^2.

    Parameters
    ----------
    twist : float
        Angle by reference length, tau [1/m].
    radius : float
        Reference radius, a [m].
    c10, c01 : float
        [Pa].
    stretch : float
        lambda [-], positive.

    Raises
    ------
    ValueError
        For a stretch or a radius that is not positive.

    Notes
    -----
    r = R/sqrt(lambda), theta = Theta + tau Z, z = lambda Z; sigma = -p I + 2 c10 b - 2 c01 b^-1 gives
    sigma_tz = 2 r tau (c10 lambda + c01), sigma_r - sigma_t = -2 c10 r^2 tau^2, integrated from the free
    side. dM/dlambda = dN/dtau: both come from one energy.
    """
    if not (stretch > 0 and radius > 0):
        raise ValueError(f"stretch is {stretch} and radius {radius} m; both must be positive.")
    moment = pi * radius**4 * twist * (c10 / stretch + c01 / stretch**2)
    pull = 2 * pi * radius**2 * (stretch - stretch**-2) * (c10 + c01 / stretch)
    push = pi / 2 * radius**4 * twist**2 * (c10 + 2 * c01 / stretch) / stretch**2
    return Torsion(moment, pull - push)


def poynting_stretch(twist: float, radius: float, c10: float, c01: float) -> float:
    """Axial stretch of a twisted cylinder without axial force, N(lambda, tau) = 0 [-].

    A Mooney-Rivlin cylinder lengthens: lambda - 1 = (a tau)^2/12 (c10 + 2 c01)/(c10 + c01) at first.
    """

    def force(stretch: float) -> float:
        return torsion_of_cylinder(twist, radius, c10, c01, stretch).axial_force

    # N = 0 is lambda^3 - 1 = (a tau)^2/4 (c10 + 2 c01/lambda)/(c10 + c01/lambda), at most (a tau)^2/2
    high = (1 + (radius * twist) ** 2) ** (1 / 3)
    return 1.0 if twist == 0 else bracketed_root(force, 1.0, high)
