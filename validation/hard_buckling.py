"""Buckling: perfect and imperfect columns, rods pushed together between clamps; and what is still waiting."""

from __future__ import annotations

from collections.abc import Iterator

from validation.hard_case import HardCase
from validation.hard_limits import WALKED, deviation
from validation.hard_scenes import (
    BOTH_ENDS,
    UP,
    arm,
    force,
    from_buckled,
    from_stretch,
    gravity,
    stable_stretch,
    standing,
)

EULER = 2.4674011002723395  # pi^2/4: buckling load of the clamped-free column in E I/L^2 (Euler 1744)
# The path of an imperfect column turns off within imperfection^(2/3) of the buckling load (Koiter 1945): with
# steps of a hundredth a walk may pass the bend and stay on the unstable branch, and its work is not resolved.
TURNS = "only the small lateral load keeps a round column from turning about its first axis"
SHARP = "the path bends within less than one step of the walk"


def buckling() -> Iterator[HardCase]:
    """Columns, perfect and not, and rods between two clamps."""
    family = "buckling"
    yield HardCase(
        family,
        "perfect column at 3 Euler loads",
        arm(force=[force([-3 * EULER, 0, 0])]),
        "the straight shape is an equilibrium, and the result warns that it is unstable",
        said="unstable",
        limits=deviation(1e-4, "uniaxial compression; the clamp holds the section over R"),
        deviation=from_stretch(stable_stretch(-3 * EULER / (4.0 * 40.0**2))),
    )
    yield HardCase(
        family,
        "column with 0.1 % lateral load at 3 Euler loads",
        arm(force=[force([-3 * EULER, 3e-3 * EULER, 0])]),
        "one long step would land on the unstable, nearly straight shape; the path takes the buckled one",
        limits=deviation(3e-2, "buckled elastica; finite strain, kappa R = 0.1, and the lateral load"),
        deviation=from_buckled(3.0),
        stable=True,
        not_asked={"energy order off 2": SHARP, "energy balance": SHARP},
    )
    near = deviation(
        5e-3, "buckled elastica; finite strain 1.4 (kappa R)^2 = 1e-3 at most, mesh, lateral load"
    )
    for euler, share, slenderness in ((2, 1e-3, 100), (2, 1e-4, 100), (2, 1e-6, 400), (8, 1e-3, 400)):
        yield HardCase(
            family,
            f"column with {share:.0e} lateral load at {euler} Euler loads".replace("e-0", "e-"),
            arm(slenderness, force=[force([-euler * EULER, share * euler * EULER, 0], slenderness)],
                elements=24),
            "a small imperfection: the path turns off within a small part of the buckling load",
            limits=near,
            deviation=from_buckled(euler),
            stable=True,
            not_asked={**dict.fromkeys(WALKED, SHARP), "condition number": TURNS},
        )  # fmt: skip
    for number in (10, 100):
        yield HardCase(
            family,
            f"upright, 0.1 % sideways, rho g A L3/EI = {number}",
            arm(100, gravity=gravity(number, [1e-3, 0.0, -1.0], 100), base=standing(UP)),
            "past Greenhill's 7.84 an imperfect column falls over; its path ends on a stable shape",
            stable=True,
            not_asked=dict.fromkeys(WALKED, SHARP),
        )
    yield HardCase(
        family,
        "clamped at both ends, pushed together from the middle",
        arm(100, force=[force([60, 0.06, 0], 100, at=0.5)], supports=BOTH_ENDS),
        "one half is pulled, the other pushed by 30 E I/L^2 and more; 0.1 % lateral load",
    )
    yield HardCase(
        family,
        "clamped at both ends, pushed past buckling",
        arm(100, force=[force([400, 0.4, 0], 100, at=0.5)], supports=BOTH_ENDS),
        "the pushed half carries 200 E I/L^2, its buckling load is 4 pi^2 E I/(L/2)^2 = 158",
    )
