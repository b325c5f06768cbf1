"""Rods of which single components are moved or held, against closed forms of what that takes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.scene import Scene
from reference.elastica import elastica_tip_force
from validation.cases import Case
from validation.outcome import Outcome, Row
from validation.scenes import NoEquilibrium

Floats = NDArray[np.float64]
# Force [N], couple [N m] and place [m] of the end of the rod; None where no closed form is known.
Answer = tuple[Floats, Floats, Floats | None]


def moved(case: Case) -> Outcome:
    """What the motion of the end of a rod clamped at 0 along x carries, and the most in what it leaves free.

    Both by the larger of the exact force and couple/L. `kind` in the parameters names the answer, of
    `ANSWERS`; `load` is its P L^2/(E I).
    """
    solution = ancf.solve(ancf.scene_from_dict(case.scene))
    if solution.status is not ancf.Status.CONVERGED:
        raise NoEquilibrium(solution.reason)
    (rod,), (carried,) = solution.scene.rods, solution.joints
    EI = rod.material.young_modulus * rod.section.weaker_second_moment
    force, couple, place = ANSWERS[case.parameters["kind"]](
        solution.scene, EI, float(case.parameters.get("load", 0.0))
    )
    size = max(np.linalg.norm(force), np.linalg.norm(couple) / rod.length)
    found = np.concatenate([carried.force, carried.moment / rod.length]) / size
    exact = np.concatenate([force, couple / rod.length]) / size
    hold = carried.joint.hold
    free = [i for i, name in enumerate(("x", "y", "z", "rx", "ry", "rz")) if name not in hold]
    rows = [
        Row(f"{kind} {axis}", float(a), float(b), unit)
        for kind, values, exact_values, unit in (
            ("force", carried.force, force, "N"),
            ("moment", carried.moment, couple, "N m"),
        )
        for axis, a, b in zip("xyz", values, exact_values, strict=True)
    ]
    observed = {
        "carried": float(np.linalg.norm(found - exact)),
        "free components": float(np.max(np.abs(found[free]))),
    }
    if place is not None:
        observed["tip position"] = float(np.linalg.norm(solution.tip().position - place)) / rod.length
    return Outcome(observed, rows, solution, case.scene)


def _roller(scene: Scene, EI: float, load: float) -> Answer:
    """Only y is moved, to where the elastica has its end under a force along y; x slides as it does."""
    L = scene.rods[0].length
    exact = elastica_tip_force(load)
    return np.array([0.0, load * EI / L**2, 0.0]), np.zeros(3), L * np.array([1.0 - exact.u, exact.w, 0.0])


def _propped(scene: Scene, EI: float, load: float) -> Answer:
    """A roller under the end of a cantilever with a line load along y carries 3/8 of it."""
    (line,) = scene.line_loads
    return -0.375 * scene.rods[0].length * line.value, np.zeros(3), None


def _turned(scene: Scene, EI: float, load: float) -> Answer:
    """The end is turned by phi about z alone: an arc, M = E I phi/L."""
    L, phi = scene.rods[0].length, float(scene.joints[0].rotation[2])
    arc = L / phi * np.array([math.sin(phi), 1.0 - math.cos(phi), 0.0])
    return np.zeros(3), np.array([0.0, 0.0, EI * phi / L]), arc


def _guided(scene: Scene, EI: float, load: float) -> Answer:
    """The end is moved by w along y without turning, free to slide: 12 E I w/L^3, -6 E I w/L^2."""
    L, w = scene.rods[0].length, float(scene.joints[0].displacement[1])
    return np.array([0.0, 12.0 * EI * w / L**3, 0.0]), np.array([0.0, 0.0, -6.0 * EI * w / L**2]), None


ANSWERS: dict[str, Callable[[Scene, float, float], Answer]] = {
    "roller": _roller,
    "propped": _propped,
    "turned": _turned,
    "guided": _guided,
}
