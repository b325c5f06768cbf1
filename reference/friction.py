r"""Rods that rub against rigid bodies: closed forms of Coulomb's law, loads growing from zero.

A body on a plane inclined by alpha stays where tan(alpha) < mu.

A rod that lies on a plane under w per length and is pulled along by F at one end slips from there as far as
friction carries F, l = F/(mu w), in which its tension falls in proportion: the end moves by F^2/(2 E A mu w).

A round rod, its radius R, slips round a cylinder of radius a as its own shape, its axis at rho = a + R. With
tension T, shear V, contact p and friction mu p on its surface, a lever R from the axis,

    T' = mu p - V/rho,   V' = T/rho - p,   V = R mu p   (no change of moment),

so T grows as exp(c s), R mu c^2 + c - mu a/rho^2 = 0: Euler's rope mu/rho where R is nothing.
"""

from __future__ import annotations

import math


def pulled_end(force: float, friction: float, axial: float) -> tuple[float, float]:
    """Slipped length [m] and way of the end [m] of a rod pulled over a plane that holds it.

    friction : mu w [N/m];  axial : E A [N]
    """
    return force / friction, force**2 / (2.0 * axial * friction)


def belt_rate(friction: float, cylinder: float, rho: float) -> float:
    """Rate c [1/m] along the axis at which tension grows; radii of the cylinder and of the axis [m]."""
    lever = (rho - cylinder) * friction
    # The root of the quadratic, without cancellation.
    last = friction * cylinder / rho**2
    return 2.0 * last / (1.0 + math.sqrt(1.0 + 4.0 * lever * last))


def rubbing_tip(length: float, bending: float, across: float, friction: float, normal: float) -> float:
    """Way [m] of a cantilever's end under a force along a plane that its end is pressed on.

    The force [N] less mu times the normal force [N], over 3 E I/L^3; none where friction carries it all.
    """
    return max(across - friction * normal, 0.0) * length**3 / (3.0 * bending)
