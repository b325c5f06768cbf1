"""Elastic bar under its own weight, hanging or standing: finite stretch with free lateral contraction.

Symbols
-------
X, x      reference and deformed distance from the support, [m]
w         weight per reference volume, rho g, positive where it stretches the bar (hanging), [N/m3]
P         nominal stress, P(X) = w (L - X), [Pa]
lambda_   axial stretch, [-]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from reference.homogeneous import PrincipalStress, uniaxial
from reference.root import bracketed_root

GAUSS_POINTS = (24, 48)  # analytic integrand: the second confirms the first to rounding
LARGEST_STRETCH, SMALLEST_STRETCH = 10.0, 0.1
SEARCH_STEP = 1.02  # factor between the stretches tried: finds loads to 1e-4 of a largest one


@dataclass(frozen=True)
class HangingBar:
    """Bar under its weight: distance of the free end from the support and its estimated error [m].

    support_stretch, support_lateral: axial and lateral stretch at the support [-].
    """

    tip: float
    error: float
    support_stretch: float
    support_lateral: float


def hanging_bar(law: PrincipalStress, weight: float, length: float) -> HangingBar:
    """Position of the free end of a bar that hangs (weight > 0) or stands (weight < 0) on its support.

    x' = lambda(P), P(lambda, t, t) = w (L - X), free sides. With X = L - P/w the length is
    x(L) = (1/w) int_0^{wL} lambda dP = (lambda_0 P_0 - int_1^{lambda_0} P dlambda)/w, so that only
    lambda_0, at the support, needs a root. The sections are plane and free to contract, also at the support
    (a slender bar).

    Parameters
    ----------
    law : nominal principal stress, `principal_saint_venant_kirchhoff` and so on of `homogeneous`
    weight : rho g [N/m3], of the reference volume
    length : [m]

    Returns
    -------
    HangingBar

    Raises
    ------
    ValueError where no stretch between 0.1 and 10 carries the weight, as for a standing bar of Saint
    Venant-Kirchhoff material at |w| L > E/(3 sqrt 3), or where the free sides have no equilibrium.

    Notes
    -----
    Linear: x(L) - L = w L^2/(2 E). Saint Venant-Kirchhoff in closed form: `hanging_saint_venant_kirchhoff`.
    Antman, Nonlinear Problems of Elasticity, ch. 2. Relative accuracy 1e-13, some 10 ms.
    """
    if weight == 0:
        return HangingBar(length, 0.0, 1.0, 1.0)

    def stress(stretch: float) -> float:
        return uniaxial(law, stretch).stress

    top = weight * length
    support = _stretch(stress, top)
    tips = []
    for count in GAUSS_POINTS:
        nodes, weights = np.polynomial.legendre.leggauss(count)
        half = (support - 1) / 2
        energy = half * float(weights @ [stress(1 + half * (1 + x)) for x in nodes.tolist()])
        # The displacement (1/w) int (lambda - 1) dP: L is not the difference of large terms.
        tips.append(length + ((support - 1) * top - energy) / weight)
    rounding = 1e-15 * (abs(tips[1]) + length)
    return HangingBar(tips[1], abs(tips[1] - tips[0]) + rounding, support, uniaxial(law, support).free)


def hanging_saint_venant_kirchhoff(young_modulus: float, weight: float, length: float) -> float:
    """Position of the free end [m] for P = E lambda (lambda^2 - 1)/2: closed form.

    x(L) = (lambda_0 P_0 - E (lambda_0^2 - 1)^2/8)/w, P_0 = w L = E (lambda_0^3 - lambda_0)/2; weight [N/m3]
    not zero, of either sign, w L >= -E/(3 sqrt 3).
    """
    top = weight * length

    def excess(stretch: float) -> float:
        return young_modulus * (stretch**3 - stretch) / 2 - top

    support = bracketed_root(excess, 3**-0.5, 2.0 + (2 * abs(top) / young_modulus))
    return length * support - young_modulus * (support**2 - 1) ** 2 / (8 * weight)


def _stretch(stress: Callable[[float], float], target: float) -> float:
    """Stretch with this stress on the branch of rising stress that starts at 1."""
    factor = SEARCH_STEP if target > 0 else 1 / SEARCH_STEP
    near, here = 1.0, 0.0
    while SMALLEST_STRETCH < near < LARGEST_STRETCH:
        far = near * factor
        beyond = stress(far)
        if (beyond - target) * target >= 0:
            return bracketed_root(lambda x: stress(x) - target, *sorted((near, far)))
        if (beyond - here) * target <= 0:
            break
        near, here = far, beyond
    raise ValueError(f"no stretch carries the stress {target:.6g} Pa: the largest found is {here:.6g} Pa")
