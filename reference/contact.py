r"""Rods that touch rigid bodies without friction: closed forms at small deflection, and a wrapped elastica.

A beam under w per length that is held level at a height h over a plane touches it from a distance s on. From
the touchdown, at u = 0 with y = y' = y'' = 0, E I y = V u^3/6 - w u^4/24; the level end asks V = w s/3 and
h = w s^4/(72 E I). A beam on a plane that a force F lifts at its end is free of moment there, so V = w s/2,
F = w s/2 and h = w s^4/(24 E I) (Wang, J. Appl. Mech. 53 (1986) 188, treats the elastica; these are its first
order).

A rod clamped along the tangent of a cylinder, pulled across it by a force P on its end, lies on it up to the
angle phi with the curvature 1/rho of its axis there; the rest is an elastica with continuous curvature,

    theta = s/rho,  s < rho phi;     E I theta'' = -P cos(theta),  theta'(rho phi) = 1/rho,  theta'(L) = 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad

from reference.root import bracketed_root

Array = NDArray[np.float64]


def level_end_span(height: float, bending: float, load: float) -> float:
    """Free length s [m] of a beam whose level end is held at a height over the plane: (72 E I h/w)^(1/4)."""
    return float((72.0 * bending * height / load) ** 0.25)


def lifted_span(height: float, bending: float, load: float) -> float:
    """Free length s [m] of a beam whose end is lifted to a height from the plane: (24 E I h/w)^(1/4)."""
    return float((24.0 * bending * height / load) ** 0.25)


def propped_force(length: float, bending: float, load: float, at: float, clearance: float) -> float:
    """Force [N] of a rigid prop at `at` [m], a clearance away from a cantilever under a force on its end.

    P a^2 (3 L - a)/(6 E I) - R a^3/(3 E I) = clearance.
    """
    free = load * at**2 * (3.0 * length - at) / (6.0 * bending)
    return max(free - clearance, 0.0) * 3.0 * bending / at**3


def wrapped_tip(length: float, bending: float, force: float, rho: float) -> tuple[Array, float]:
    """End (2,) [m] of the wrapped rod along the tangent and along the force, and the angle phi [rad].

    Inextensible and without shear. With the first integral E I theta'^2/2 + P sin(theta) = P sin(theta_L) and
    theta = theta_L - u^2 length and place are integrals of smooth functions, to 1e-10.
    """
    lift = bending / (2.0 * force * rho**2)  # sin(theta_L) - sin(phi)
    if lift >= 1.0 or _free_part(0.0, lift, bending, force)[0] > length:
        raise ValueError("the rod does not lie on the cylinder")
    # At the upper end the free part would be infinitely long: a rope.
    steepest = float(np.arcsin(1.0 - lift)) * (1.0 - 1e-15)
    phi = bracketed_root(
        lambda angle: rho * angle + _free_part(angle, lift, bending, force)[0] - length, 0.0, steepest
    )
    _, x, y = _free_part(phi, lift, bending, force)
    return np.array([rho * np.sin(phi) + x, rho * (1.0 - np.cos(phi)) + y]), phi


def _free_part(phi: float, lift: float, bending: float, force: float) -> Array:
    """Length [m] of the elastica from the angle phi to its end without moment, and its extent (2,) [m]."""
    end = float(np.arcsin(min(np.sin(phi) + lift, 1.0)))

    def per_u(u: float, what: int) -> float:
        theta = end - u * u
        # sin(end) - sin(theta) = 2 cos((end + theta)/2) sin(u^2/2), without cancellation.
        drop = 4.0 * force / bending * np.cos(end - 0.5 * u * u) * np.sin(0.5 * u * u)
        ds = 2.0 * u / np.sqrt(drop) if u > 0.0 else 2.0 / np.sqrt(2.0 * force / bending * np.cos(end))
        return float(ds * (1.0, np.cos(theta), np.sin(theta))[what])

    top = float(np.sqrt(end - phi))
    parts = [quad(per_u, 0.0, top, args=(what,), epsabs=1e-12, epsrel=1e-11, limit=400) for what in range(3)]
    return np.array([part[0] for part in parts])


def crossing_force(load: float, length: float, bending: float, other_length: float, other: float) -> float:
    """Force [N] between the ends of two cantilevers that cross; one carries a force on its end.

    Both ends move alike: R = P k_2/(k_1 + k_2), k = 3 E I/L^3.
    """
    k_1, k_2 = 3.0 * bending / length**3, 3.0 * other / other_length**3
    return load * k_2 / (k_1 + k_2)
