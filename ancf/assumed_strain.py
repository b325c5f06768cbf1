r"""Assumed strains: strain products that are sampled elsewhere than at the axial points.

    gamma_bar_p(x_g) = sum_s A_gs,p gamma_p(x_s),    A_gs,p = L_s(x_g)

with the Lagrange polynomials L_s of the places where products of the kind of p are sampled; a kind that the
element does not name is taken at the axial points themselves (A = identity). A function of gamma_bar stays a
potential, so force and tangent follow by the chain rule (energy.py). Strains that are constant along an
element stay as they are: rigid motions and patches are untouched.

Why: directors between nodes are interpolated, so a section that turns shrinks there. Strains of the section
(r_y . r_y, ...) that are sampled at the nodes, where directors are free, do not see it: what
curvature-thickness locking a reduced axial rule leaves is gone (Betsch, Stein, Commun. Numer. Methods Eng. 11
(1995) 899, for shells). The axial strain of a cable is sampled where its shape can be inextensible.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ancf.elements import R_X, Element, Order
from ancf.quadrature import gauss
from ancf.section_energy import pairs

Floats = NDArray[np.float64]

SAME = 1e-12  # places closer than this, in xi, are one


def kind_of(first: Order, second: Order) -> str:
    """Which strain the product of two generalised vectors belongs to.

    ``axial`` r_x . r_x; ``shear`` r_x with a director; ``section`` directors with each other; ``curvature``
    every product with a derivative of a director, or with r_xx.
    """
    orders = (first, second)
    if any(order[0] > 0 and order != R_X for order in orders):
        return "curvature"
    return ("section", "shear", "axial")[sum(order == R_X for order in orders)]


@lru_cache(maxsize=32)
def sampling(element: Element, points: int) -> tuple[Floats, Floats]:
    """Where an element samples its strain products, and what the axial points see of them.

    Returns
    -------
    Places (places,) [xi], the axial points first, and A (points, places, pairs).
    """
    axial, _ = gauss(points)
    places = list(axial)
    for _, sampled in element.assumed:
        places += [xi for xi in sampled if min(abs(np.array(places) - xi)) > SAME]
    at = np.array(places)
    assumed = dict(element.assumed)
    vectors = element.generalised
    A = np.zeros((points, len(at), len(pairs(len(vectors))[0])))
    for p, (i, j) in enumerate(zip(*pairs(len(vectors)), strict=True)):
        sampled = assumed.get(kind_of(vectors[i], vectors[j]))
        if sampled is None:
            A[:, :points, p] = np.eye(points)
            continue
        columns = [int(np.argmin(np.abs(at - xi))) for xi in sampled]
        A[:, columns, p] = _lagrange(np.array(sampled), axial)
    for values in (at, A):
        values.setflags(write=False)
    return at, A


def interpolated(element: Element, kind: str, points: int, values: Floats) -> Floats:
    """Values (n_el, points, ...) at the axial points of a field known at the places (n_el, places, ...),
    through those where the element samples strains of a kind.
    """
    axial, _ = gauss(points)
    at, _ = sampling(element, points)
    sampled = np.array(dict(element.assumed)[kind])
    columns = [int(np.argmin(np.abs(at - xi))) for xi in sampled]
    return np.einsum("gs,es...->eg...", _lagrange(sampled, axial), values[:, columns])


def _lagrange(places: Floats, xi: Floats) -> Floats:
    """Lagrange polynomials of the places (s,) at xi (g,): (g, s)."""
    to_one = np.vander(places, increasing=True)
    return np.vander(xi, len(places), increasing=True) @ np.linalg.inv(to_one)
