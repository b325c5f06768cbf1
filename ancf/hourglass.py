r"""Hourglass control: what two axial points do not see of the strains of the sections.

Two Gauss points are the zeros of P_2(xi) = (3 xi^2 - 1)/2. Sections that swell by P_2 along a quadratic
element strain there by nothing; their warping, u_x = -(swelling)' y^2/2, takes the shear away as well, and in
a long element next to no energy is left. The swelling is in the second difference of the strain products
between directors, gamma_p at the nodes,

    eta_p = gamma_p(-1) - 2 gamma_p(0) + gamma_p(1) = 3 (share of P_2),

and the energy that the exact integral over the element gives it, int P_2^2 dx = h/5, is

    U = 1/2 c h/45 int 2 mu E : E dA,   E = 1/2 (second difference of the metric of the section),

with c = rho h/(h^2 + (k rho)^2), rho the radius of gyration. In long elements c = rho/h makes it the energy
of a layer: what a clamp does to the sections decays within about rho, not within the element. Short
elements have energy enough by the gradient, and there c falls with h, so that the order of the element
stays. At the nodes directors are free, so a turning section does not shrink there and eta vanishes in
bending; it is of the order h^2 where the contraction changes along the rod.

k is measured (`Element.long_from`): with 16 two elements of 3363 fail at L/R = 20; with 8 the order of 3343
on curved rods is 3.3 between 16 and 32 elements, with 12 it is 3.8; with 12 nearly incompressible rubber on
3363 needs load steps, with 8 none. (Flanagan, Belytschko, Int. J. Numer. Meth. Eng. 17 (1981) 679.)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.elements import Element
from ancf.section_energy import pairs

Floats = NDArray[np.float64]

NODES = np.array([-1.0, 0.0, 1.0])
SECOND_DIFFERENCE = np.array([1.0, -2.0, 1.0])


def swelling(element: Element) -> Floats:
    """Map (1, nodes, pairs) from the products of the directors at the nodes to eta."""
    count = len(pairs(len(element.directors) - 1)[0])
    return np.multiply.outer(SECOND_DIFFERENCE, np.ones(count))[None]


def of_directors(element: Element, H: Floats) -> Floats:
    """The part of H (pairs, pairs) that belongs to products between directors."""
    i, j = pairs(len(element.generalised))
    first = len(element.directors)  # the slopes come before
    chosen = np.flatnonzero((i >= first) & (j >= first))
    return H[np.ix_(chosen, chosen)]


def control_weight(h: float, radius_of_gyration: float, long_from: float) -> float:
    """c h/45 [m] for an element of length h [m]; `long_from` is k of the module's docstring."""
    return radius_of_gyration * h / (h**2 + (long_from * radius_of_gyration) ** 2) * h / 45.0
