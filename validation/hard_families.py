"""Hard shapes: slender rods, many turns, Poisson ratios, moduli, meshes, torsion."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from validation.criteria import Limit
from validation.hard_case import TYPED, HardCase
from validation.hard_limits import MESH_CIRCLE, MESH_QUARTER, WALKED, deviation, energy, thin
from validation.hard_scenes import (
    FREE_SECTION,
    FULL_CIRCLE,
    QUARTER,
    arm,
    force,
    from_arc,
    from_helix,
    from_rod,
    moment,
    rolled,
)

COMING = 60  # iterations in all that the issue allows from the straight shape, without predictor


def shapes() -> Iterator[HardCase]:
    """All families of this module."""
    yield from _slender()
    yield from _turns()
    yield from _materials()
    yield from _meshes()
    yield from _torsion()


def _slender() -> Iterator[HardCase]:
    family = "slenderness"
    yield HardCase(
        family,
        "full circle, L/R = 5",
        rolled(FULL_CIRCLE, 5),
        "kappa R = 1.26: the moment exceeds the largest that the section of Saint Venant-Kirchhoff carries",
        TYPED,
    )
    said = {
        40: "the tip comes back to the base; finite strain turns it further",
        400: "the same, a hundred times less finite strain",
        4000: "float64 positions leave a residual of 6e-7 here; the floor is reported",
    }
    for slenderness, meaning in said.items():
        limits = thin(FULL_CIRCLE, slenderness, MESH_CIRCLE)
        name = f"full circle, L/R = {slenderness}"
        scene = rolled(FULL_CIRCLE, slenderness)
        walk = "quick" if slenderness == 400 else "full"
        exact = from_arc(FULL_CIRCLE)
        yield HardCase(family, name, scene, meaning, limits=limits, deviation=exact, walk=walk)
    yield HardCase(
        family,
        "full circle, L/R = 40000",
        rolled(FULL_CIRCLE, 40000, elements=24),
        "axial over bending stiffness 6e9: the floor of the residual is 1e-4, the answer is still an arc",
        limits=thin(FULL_CIRCLE, 40000, MESH_CIRCLE),
        deviation=from_arc(FULL_CIRCLE),
    )


def _turns() -> Iterator[HardCase]:
    for turns in (2, 4):
        angle = turns * FULL_CIRCLE
        yield HardCase(
            "turns",
            f"{turns} turns, L/R = 400",
            rolled(angle, 400, elements=12 * turns),
            "twelve elements a turn; the tip comes back to the base each time",
            limits=(*thin(angle, 400, MESH_CIRCLE), energy(angle)),
            deviation=from_arc(angle),
            walk="quick" if turns == 2 else "full",
        )
    yield HardCase(
        "turns",
        "4 turns, L/R = 40",
        rolled(4 * FULL_CIRCLE, 40, elements=48),
        "kappa R = 0.63: 1.5 times the largest moment of the section, 0.41 E I/R (theory.md 2)",
        TYPED,
    )


def _materials() -> Iterator[HardCase]:
    near = deviation(2e-3, "1.375 (kappa R)^2 = 2.1e-3 in angle; less where nu changes the section's part")
    for nu in (0.0, 0.3, 0.49, 0.4999, 0.499999):
        yield HardCase(
            "Poisson ratio",
            f"nu = {nu:g}, 90 degrees",
            rolled(QUARTER, nu=nu),
            "no Poisson locking with the enhanced law, however near to incompressible",
            limits=near,
            deviation=from_arc(QUARTER),
            walk="quick" if nu == 0.3 else "full",
        )
    for young in (1e2, 1e4, 1e8, 1e10, 1e12):
        yield HardCase(
            "modulus",
            f"E = {young:.0e} Pa, 90 degrees".replace("e+0", "e").replace("e+", "e"),
            rolled(QUARTER, young=young),
            "the tolerance is dimensionless: same digits",
            limits=near,
            deviation=from_arc(QUARTER),
        )


def _meshes() -> Iterator[HardCase]:
    family = "mesh"
    one = deviation(5e-2, "one quadratic element for a quarter circle: 2.8e-3 with two (theory.md 3)")
    fine = thin(QUARTER, 400, MESH_QUARTER)
    exact = from_arc(QUARTER)
    for elements, limits in ((1, one), (200, fine), (1000, fine)):
        yield HardCase(
            family,
            f"{elements} elements, 90 degrees".replace("1 elements", "1 element"),
            rolled(QUARTER, 400, elements=elements),
            "cost grows linearly, the floor with the number of elements"
            if elements > 1
            else "the coarsest mesh",
            limits=limits,
            deviation=exact,
            not_asked=dict.fromkeys(WALKED, "a hundred solves of 18 000 unknowns")
            if elements == 1000
            else {},
        )
    short = 0.5 / 6 * 1e-4  # of the length: 1e-4 of its neighbours, 6 elements on half a rod
    couple = [
        moment([0, 0, QUARTER], 400),
        moment([0, 0, 1.0], 400, at=0.5),
        moment([0, 0, -1.0], 400, at=0.5 + short),
    ]
    yield HardCase(
        family,
        "neighbouring elements 1 : 1e4",
        arm(400, moment=couple, elements=13),
        "two moments that cancel stand 8e-6 L apart with one element between; they turn the rod by as much",
        limits=thin(QUARTER, 400, MESH_QUARTER),
        deviation=exact,
    )
    as_3333 = thin(FULL_CIRCLE, 400, MESH_CIRCLE)[0].value
    for element, limit, why in (
        ("3363", as_3333, "as 3333"),
        ("3343", as_3333, "as 3333"),
        ("3243", 0.5, "curvature-thickness locking (theory.md 3): not the limit of a good element"),
    ):
        yield HardCase(
            family,
            f"full circle, element {element}",
            rolled(FULL_CIRCLE, 400, element=element, elements=24),
            "the other elements",
            limits=deviation(limit, why),
            deviation=from_arc(FULL_CIRCLE),
        )
    for element in ("3343", "3363"):
        yield HardCase(
            family,
            f"4 long elements {element}, free section",
            rolled(QUARTER, 400, element=element, elements=4, supports=FREE_SECTION),
            "h = 100 R, and nothing holds the sections but their own strain (hourglass.py)",
            limits=thin(QUARTER, 400, 4 * MESH_QUARTER),
            deviation=from_arc(QUARTER),
        )
    steep = Limit(
        "energy balance", 5e-3, "U", "most of the turn happens in the first steps of a hundred",
        kind="non-regression",
    )  # fmt: skip
    for number, elements in ((1, 24), (100, 24), (1000, 96)):
        own = deviation(1e-3, "the layer of length L/sqrt(2 number) at the clamp, two elements or more")
        yield HardCase(
            family,
            f"cable, tip force P L2/EI = {number}",
            arm(4000, element="cable", elements=elements, force=[force([0, number, 0], 4000)]),
            "no sections: bending that gives way to tension",
            limits=(*own, steep) if number == 100 else own,
            deviation=from_rod,
            not_asked=dict.fromkeys(WALKED, "the first of a hundred steps turns the rod by half")
            if number == 1000
            else {},
        )


def _torsion() -> Iterator[HardCase]:
    family = "torsion"
    # Four turns in all: |M| L/EI = 8 pi, in no special direction.
    oblique = 8.0 * math.pi * np.array([0.48, 0.6, 0.64])
    for direction in ("fixed", "follower"):
        yield HardCase(
            family,
            f"oblique {direction} moment, 4 turns",
            arm(400, moment=[moment(oblique, 400, direction=direction)], elements=48),
            "bending and twist together; the moment "
            + ("is fixed in space" if direction == "fixed" else "turns with the section"),
            limits=(*thin(8.0 * math.pi, 400, MESH_CIRCLE), energy(8.0 * math.pi)),
            deviation=from_helix(direction),
        )
    iterations = Limit(
        "iterations", COMING, "-", "required by the issue: from the straight shape, without predictor",
        kind="non-regression",
    )  # fmt: skip
    for slenderness in (40, 400):
        load = moment([1.5, 0.0, FULL_CIRCLE], slenderness)
        yield HardCase(
            family,
            f"full circle with torsion, no predictor, L/R = {slenderness}",
            arm(slenderness, moment=[load], solver={"predictor": "none"}),
            "from the straight shape: the first full step stretches axis and sections",
            limits=(*thin(math.hypot(1.5, FULL_CIRCLE), slenderness, MESH_CIRCLE), iterations),
            deviation=from_helix(),
            walk="quick" if slenderness == 400 else "full",
        )
