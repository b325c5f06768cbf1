"""Rods bent by tendons, chambers under pressure and fields, against reference/actuation.py."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.scene import Scene
from ancf.solution import Solution
from reference.actuation import (
    MU_0,
    chamber_arc,
    closed_tube_strain,
    magnet_tip,
    tendon_rod,
    tendon_rod_of_length,
)
from validation.cases import Case
from validation.outcome import Outcome, Row
from validation.scenes import NoEquilibrium

Floats = NDArray[np.float64]


def actuated(case: Case) -> Outcome:
    """Tip position of a rod clamped at 0 along x; `kind` in the parameters names the answer, of `TIPS`."""
    solution = _solved(case)
    exact, uncertainty = TIPS[case.parameters["kind"]](solution.scene)
    length = solution.scene.rods[0].length
    tip = solution.tip().position
    rows = [Row(f"tip {axis}", float(a), float(b), "m") for axis, a, b in zip("xyz", tip, exact, strict=True)]
    observed = {"tip position": float(np.linalg.norm(tip - exact)) / length}
    return Outcome(observed, rows, solution, case.scene, {"tip position": uncertainty / length})


def closed_tube(case: Case) -> Outcome:
    """Axial strain of a tube under pressure in its middle third, relative to Lame's."""
    solution = _solved(case)
    (rod,), (chamber,) = solution.scene.rods, solution.scene.pressures
    material = rod.material
    exact = closed_tube_strain(
        chamber.radius,
        rod.section.outer_radius,
        material.young_modulus,
        material.poisson_ratio,
        chamber.value,
    )
    third = solution.pose(None, 2.0 / 3.0).position - solution.pose(None, 1.0 / 3.0).position
    strain = float(np.linalg.norm(third)) / (rod.length / 3.0) - 1.0
    rows = [Row("axial strain", strain, exact, "-")]
    return Outcome({"axial strain": abs(strain / exact - 1.0)}, rows, solution, case.scene)


def _solved(case: Case) -> Solution:
    solution = ancf.solve(ancf.scene_from_dict(case.scene))
    if solution.status is not ancf.Status.CONVERGED:
        raise NoEquilibrium(solution.reason)
    return solution


def _tendon(scene: Scene) -> tuple[Floats, float]:
    (rod,), (tendon,) = scene.rods, scene.tendons
    material = rod.material
    numbers = (rod.length, rod.section.outer_radius, material.young_modulus, material.poisson_ratio)
    if tendon.length is not None:
        return tendon_rod_of_length(*numbers, tendon.length, tendon.path, tendon.friction)[:2]
    assert tendon.tension is not None
    return tendon_rod(*numbers, tendon.tension, tendon.path, tendon.friction)


def _chamber(scene: Scene) -> tuple[Floats, float]:
    (rod,), (chamber,) = scene.rods, scene.pressures
    # The thrust on the far end cap acts at the centre (y, 0): it bends about z, away from the chamber.
    couple = -chamber.value * math.pi * chamber.radius**2 * float(chamber.centre[0])
    return chamber_arc(rod.length, _stiffness(scene), couple), 0.0


def _magnet(scene: Scene) -> tuple[Floats, float]:
    (rod,), (magnet,) = scene.rods, scene.magnets
    size = float(np.linalg.norm(magnet.field))
    couple = float(magnet.remanence[0]) * size * rod.section.area / MU_0
    return magnet_tip(rod.length, _stiffness(scene), couple, math.atan2(magnet.field[1], magnet.field[0]))


def _stiffness(scene: Scene) -> float:
    (rod,) = scene.rods
    return rod.material.young_modulus * rod.section.weaker_second_moment


TIPS: dict[str, Callable[[Scene], tuple[Floats, float]]] = {
    "tendon": _tendon,
    "chamber": _chamber,
    "magnet": _magnet,
}
