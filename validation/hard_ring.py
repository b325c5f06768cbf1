"""Rods whose ends are brought together: the elastica loop, and the ring that leaves its plane under twist."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ancf.model import Model
from ancf.solution import Solution
from reference.buckling import euler_load
from reference.critical_loads import ring_twist
from reference.elastica import elastica_closing_ratio, elastica_shortening
from reference.root import bracketed_root
from validation.criteria import Limit
from validation.hard_case import HardCase
from validation.hard_limits import WALKED
from validation.hard_scenes import LENGTH, arm, bending_stiffness

Floats = NDArray[np.float64]

SLENDER = 400.0  # thicker rings lose stability earlier: by 2 % at L/R = 100
NAME = "ring"
TOGETHER = 0.9  # of the length; at 1 the closed figure may slide along itself, and no shape is singled out
JOINED = {
    **dict.fromkeys(WALKED, "its load is a prescribed motion, which has no equal steps of loads"),
    "condition number": "forces of joints stand in rows of their own scale",
    "Newton order by steps below 2": "the start is the answer but for strain; no order is left to see",
}


def ring() -> Iterator[HardCase]:
    """Half a percent below and above the critical twist."""
    EI = bending_stiffness(SLENDER)
    GJ = EI / 1.3  # round, nu = 0.3: G J = E I/(1 + nu)
    critical = ring_twist(EI, GJ, LENGTH / (2.0 * math.pi)).angle
    for share, word in ((0.995, "below"), (1.005, "above")):
        twist = share * critical
        yield HardCase(
            "ring",
            f"ring, total twist 0.5 % {word} Michell's",
            _scene(twist),
            "a straight rod bent to a ring and twisted leaves its plane at 2 pi sqrt(3) E I/(G J)",
            said="" if share < 1.0 else "unstable",
            limits=(
                Limit("deviation", 2e-3, "of the torque", "G J twist/L; extension", kind="non-regression"),
            ),
            deviation=lambda solution, twist=twist: torque_error(solution, GJ * twist / LENGTH),
            start=lambda model, twist=twist: closed(model, twist),
            stable=True if share < 1.0 else None,
            drifts="full",
            not_asked=JOINED,
        )


def _limit(what: str, reason: str) -> tuple[Limit, ...]:
    return (Limit("deviation", 2e-3, f"of the {what}", reason, kind="non-regression"),)


def loop() -> Iterator[HardCase]:
    """A straight rod between two clamps that come together, to a tenth of its length."""
    EI = bending_stiffness(SLENDER)
    ratio = bracketed_root(lambda k: elastica_shortening(k) - TOGETHER, 1.0 + 1e-9, elastica_closing_ratio())
    exact = ratio * euler_load(EI, LENGTH, "clamped-clamped")
    bow = [0.0, 0.0, 0.003 / LENGTH]  # moves the moment by a constant, and the ends by 0.003 rad
    scene = arm(SLENDER, elements=32, name=NAME, supports=[{"at": 0.0}], curvature=bow)
    scene["joint"] = [_held([-TOGETHER * LENGTH, 0.0, 0.0], [0.0, 0.0, 0.0])]
    yield HardCase(
        "ring",
        "elastica loop: the ends brought together",
        scene,
        "between clamps, bowed a little: it buckles and bulges until its ends are 0.1 L apart",
        limits=_limit("force", "elastica; the bow, extension, mesh"),
        deviation=lambda solution: abs(float(np.linalg.norm(solution.joints[0].force)) / exact - 1.0),
        drifts="full",
        not_asked=JOINED,
    )


def _held(displacement: list[float], rotation: list[float]) -> dict:
    """The joint that brings the far end to a place."""
    return {
        "kind": "rigid", "a": {"rod": NAME, "at": 1.0}, "b": "ground",
        "displacement": displacement, "rotation": rotation,
    }  # fmt: skip


def _scene(twist: float) -> dict:
    """Clamped at 0; the other end is brought to the clamp and turned about its tangent."""
    scene = arm(SLENDER, elements=48, name=NAME, supports=[{"at": 0.0}])
    scene["joint"] = [_held([-LENGTH, 0.0, 0.0], [twist, 0.0, 0.0])]
    return scene


def closed(model: Model, twist: float) -> Floats:
    """Coordinates (n,) of the ring, its twist even along it: R = Exp(2 pi u/L e_z) Exp(twist u/L e_x).

    u is the distance from the clamp, whichever end it holds.
    """
    q = model.q0.copy()
    for rod in model.rods:
        if rod.rod.name != NAME:
            continue
        L, A = rod.rod.length, rod.rod.base.rotation
        held = rod.rod.supports[0].at * L
        nodal = rod.q0.copy()
        for i, x in enumerate(rod.mesh.node_x):
            bend, turn = 2.0 * math.pi * (x - held) / L, twist * (x - held) / L
            radius = L / (2.0 * math.pi)
            place = np.array([held + radius * math.sin(bend), radius * (1.0 - math.cos(bend)), 0.0])
            R = _about(2, bend) @ _about(0, turn)
            nodal[i, 0] = A @ place
            for v, order in enumerate(rod.element.vectors):
                if sum(order) == 1:
                    nodal[i, v] = A @ R[:, order.index(1)]
        q[rod.first_dof : rod.first_dof + rod.size] = nodal.ravel()
    return q


def torque_error(solution: Solution, exact: float) -> float:
    """Relative error of the moment by which the ground twists the end."""
    moment = float(
        np.linalg.norm(np.dot(solution.joints[0].moment, solution.scene.rods[-1].base.rotation[:, 0]))
    )
    return abs(moment / exact - 1.0)


def _about(axis: int, angle: float) -> Floats:
    """Rotation about a coordinate axis."""
    c, s = math.cos(angle), math.sin(angle)
    R = np.eye(3)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    R[i, i] = R[j, j] = c
    R[j, i], R[i, j] = s, -s
    return R
