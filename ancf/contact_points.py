r"""Points along a rod at which contact is looked at: equal pieces of each element, ends included.

A rod touches with the surface of a tube of its undeformed radius R round the axis; beyond its ends it is
rounded off by half a ball. Normal forces act on the axis: they have no moment about it. Those of friction act
on the surface.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancf.elements import Element
from ancf.rod_model import RodModel

Floats = NDArray[np.float64]

# Pieces of an element: two give as many conditions as its axis has motions across.
FEWEST, MOST = 2, 64
# Between two points a body bulges by s^2/(8 rho); as a share of the section's radius. Where a body touches
# between two points the normal is off by s/(2 rho): 0.06 rad at rho = R, and less the larger the body.
BULGE = 2e-3
# Stiffness per length in units of E I/L^4: a rod on it gives way over (4/1e6)^(1/4) = 0.045 L. Stiffer ones
# make Newton leap (1e7: three times the iterations in a gripper), softer ones augment longer; what is found
# does not depend on it.
STIFFNESS = 1e6


@dataclass(frozen=True, eq=False)
class ContactPoints:
    """Points of one rod; those that a support holds carry no force.

    What presses on the half spacing beside a support is part of its reaction: the force that contact reports
    lacks it, of first order in the spacing. The balance of the rod does not.

    Of all elements: N (m, points, nodal) weights of the nodal vectors, slopes (m, points, 3, nodal) those of
    r_x, r_y and r_z (none of a cable, which has no sections), at (m, points) fractions of length,
    radius (m, points) [m], k (m, points) [N/m].
    """

    N: Floats
    slopes: Floats | None
    at: Floats
    radius: Floats
    k: Floats


def contact_points(model: RodModel, obstacle_radius: float) -> ContactPoints:
    """Points of all elements, dense enough for an obstacle of a radius [m]."""
    breaks, h, length = model.mesh.breaks, model.mesh.h, model.rod.length
    thinnest = min(min(part.section.outer_radius, part.last_section.outer_radius) for part in model.rod.parts)
    pieces = FEWEST
    if obstacle_radius < np.inf:
        spacing = math.sqrt(8.0 * BULGE * thinnest * (obstacle_radius + thinnest))
        pieces = int(np.clip(math.ceil(float(h.max()) / spacing), FEWEST, MOST))
    xi = np.linspace(-1.0, 1.0, pieces + 1)
    element = model.element
    N = np.array([element.shape(xi, float(size))[:, 0] for size in h])
    slopes = (
        np.array([section_slopes(element, xi, float(size)) for size in h]) if element.has_section else None
    )
    at = (breaks[:-1, None] + 0.5 * h[:, None] * (1.0 + xi)) / length
    radius = np.array([[_radius(model, min(float(place), 1.0)) for place in row] for row in at])
    share = np.full(pieces + 1, 1.0 / pieces)
    share[[0, -1]] *= 0.5
    k = STIFFNESS * model.bending_stiffness / length**4 * h[:, None] * share
    for support in model.rod.supports:
        k[np.abs(at - support.at) < 1e-9] = 0.0
    return ContactPoints(N, slopes, at, radius, k)


def section_slopes(element: Element, xi: Floats, h: float) -> Floats:
    """Weights (points, 3, nodal) of r_x, r_y and r_z at xi (points,) of an element of length h [m]."""
    directors = element.shape(xi, h)
    r_x = element.shape(xi, h, 1)[:, 0]
    return np.stack([r_x, directors[:, element.y_director], directors[:, element.z_director]], axis=1)


def surface_weights(N: Floats, slopes: Floats | None, e: Floats, arm: Floats) -> Floats:
    """Weights (m, points, nodal) of points fixed to sections at an arm (m, points, 3) [m] from the axis.

    N + A . slopes with A = [r_x r_y r_z]^-1 arm at the nodal vectors e (m, nodal, 3); the axis of a cable.
    N (m, points, nodal), slopes (m, points, 3, nodal): see `ContactPoints`.
    """
    if slopes is None:
        return N
    F = np.swapaxes(slopes @ e[:, None], -1, -2)
    A = np.linalg.solve(F, arm[..., None])
    return N + np.einsum("mpi,mpin->mpn", A[..., 0], slopes)


def _radius(model: RodModel, at: float) -> float:
    return model.rod.section_at(at).outer_radius
