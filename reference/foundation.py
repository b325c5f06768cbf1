r"""Straight rods on an elastic bed and on springs, small deflections: closed forms.

The end of a long beam on a Winkler bed, x from the end into the beam, S the shear stiffness:

    V = S (w' - phi),  M = E I phi',  V' = k w,  M' + V = 0   =>   w'''' - (k/S) w'' + (k/E I) w = 0,
    w = Re(C exp(-z x)),   z = a - i b,   a^2, b^2 = beta^2 +- k/(4 S),   beta^4 = k/(4 E I).

Balance of force and moment about the end, P = k int w dx and M_0 = k int x w dx, gives C; without shear
w(0) = 2 P beta/k and w(0) = 2 M_0 beta^2/k, up to the sign of M_0 (Hetenyi, Beams on Elastic Foundation,
1946, eq. 13-15).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def end_of_long_beam(
    x: ArrayLike, bed: float, bending: float, force: float, moment: float, shear: float = np.inf
) -> tuple[Array, Array]:
    """Deflection w (n,) [m] and rotation phi (n,) [rad] at distances x (n,) [m] from the loaded end.

    Parameters
    ----------
    bed : k [N/m2];  bending, shear : E I [N m2], S [N]
    force : P [N] on the end, along w;  moment : M_0 [N m] on the end, which turns as phi does
    """
    x = np.asarray(x, dtype=float)
    beta_2 = np.sqrt(bed / (4.0 * bending))
    z = np.sqrt(beta_2 + bed / (4.0 * shear)) - 1j * np.sqrt(beta_2 - bed / (4.0 * shear))
    # Re(C/z) = P/k, Re(C/z^2) = M_0/k for the real and imaginary part of C.
    rows = [[(1.0 / z**n).real, -(1.0 / z**n).imag] for n in (1, 2)]
    C = complex(*np.linalg.solve(rows, [force / bed, moment / bed]))
    w = C * np.exp(-z * x)
    V = -bed * w / z  # V' = k w
    return w.real, (-z * w).real - V.real / shear


def middle_of_long_beam(x: ArrayLike, bed: float, bending: float, force: float) -> Array:
    """Deflection (n,) [m] at |x| from a force on an infinite beam: P beta/(2 k) e^(-bx) (cos bx + sin bx).

    Hetenyi 1946, eq. 5.
    """
    beta = (bed / (4.0 * bending)) ** 0.25
    b = beta * np.abs(np.asarray(x, dtype=float))
    return force * beta / (2.0 * bed) * np.exp(-b) * (np.cos(b) + np.sin(b))


def propped_cantilever_tip(length: float, bending: float, force: float, spring: float, at: float) -> float:
    """Deflection [m] of the end of a cantilever under a force on it, with a spring at a distance `at` [m].

    Flexibilities of Euler and Bernoulli: f_tt = L^3/(3 E I), f_at = a^2 (3 L - a)/(6 E I), and
    f_aa = a^3/(3 E I); the spring carries R = f_at P/(f_aa + 1/k).
    """
    f_tt = length**3 / (3.0 * bending)
    f_at = at**2 * (3.0 * length - at) / (6.0 * bending)
    f_aa = at**3 / (3.0 * bending)
    return f_tt * force - f_at * f_at * force / (f_aa + 1.0 / spring)


def turned_cantilever_tip(length: float, bending: float, force: float, spring: float) -> tuple[float, float]:
    """Deflection [m] and turn [rad] of the end of a cantilever under a force on it, on a rotational spring.

    The spring [N m/rad] takes the couple k phi, so phi = P L^2/(2 E I) - k phi L/(E I) and
    w = P L^3/(3 E I) - k phi L^2/(2 E I) (Euler and Bernoulli): a quarter of P L^3/(3 E I) for k to infinity.
    """
    turn = force * length**2 / (2.0 * (bending + spring * length))
    return length**3 * force / (3.0 * bending) - spring * turn * length**2 / (2.0 * bending), turn


def turned_on_bed(x: ArrayLike, length: float, stiffness: float, bed: float, couple: float) -> Array:
    """Turn theta (n,) [rad] at x (n,) [m] of a rod on a bed [N/rad], held at 0, by a couple [N m] on its end.

    stiffness theta'' = bed theta, theta(0) = 0, stiffness theta'(L) = couple, for twist (stiffness GJ) and,
    where no force acts, for bending in a plane (E I), however far it turns:
    theta = couple sinh(b x)/(stiffness b cosh(b L)), b^2 = bed/stiffness.
    """
    b = np.sqrt(bed / stiffness)
    return np.asarray(
        couple * np.sinh(b * np.asarray(x, dtype=float)) / (stiffness * b * np.cosh(b * length))
    )
