"""Rods on springs and elastic beds at small deflections, against reference/foundation.py."""

from __future__ import annotations

from collections.abc import Callable

import ancf
from ancf.scene import Scene
from ancf.solution import Solution
from reference.foundation import end_of_long_beam, propped_cantilever_tip
from validation.cases import Case
from validation.outcome import Outcome, Row
from validation.scenes import NoEquilibrium

# Name of a number, as found and as it should be, and its unit.
Pairs = list[tuple[str, float, float, str]]


def passive(case: Case) -> Outcome:
    """Relative deviation of each number that the answer `kind` in the parameters knows, of `ANSWERS`."""
    solution = ancf.solve(ancf.scene_from_dict(case.scene))
    if solution.status is not ancf.Status.CONVERGED:
        raise NoEquilibrium(solution.reason)
    pairs = ANSWERS[case.parameters["kind"]](solution)
    rows = [Row(name, found, exact, unit) for name, found, exact, unit in pairs]
    observed = {name: abs(found / exact - 1.0) for name, found, exact, _ in pairs}
    return Outcome(observed, rows, solution, case.scene)


def _bed(solution: Solution) -> Pairs:
    """The loaded end of a rod along x, clamped far from it: deflection along y, turn about z."""
    scene = solution.scene
    (rod,), (bed,) = scene.rods, scene.foundations
    force = -sum(float(load.value[1]) for load in scene.forces)  # seen from the end, the rod lies along -x
    moment = sum(float(load.value[2]) for load in scene.moments)
    shear = rod.material.lame_mu * rod.section.area
    w, phi = end_of_long_beam([0.0], float(bed.stiffness[1]), _bending(scene), force, moment, shear)
    tip = solution.tip()
    deflection = -float(tip.position[1] - rod.base.position[1])
    turn = float(tip.rotation[1, 0])
    return [("deflection", deflection, float(w[0]), "m"), ("turn", turn, float(phi[0]), "rad")]


def _spring(solution: Solution) -> Pairs:
    """A cantilever along x under a force along y on its end, with a spring between."""
    scene = solution.scene
    (rod,), (load,), (spring,) = scene.rods, scene.forces, scene.springs
    exact = propped_cantilever_tip(
        rod.length,
        _bending(scene),
        float(load.value[1]),
        float(spring.stiffness[1, 1]),
        spring.at * rod.length,
    )
    return [("deflection", float(solution.tip().position[1]), exact, "m")]


def _bending(scene: Scene) -> float:
    (rod,) = scene.rods
    return rod.material.young_modulus * rod.section.weaker_second_moment


ANSWERS: dict[str, Callable[[Solution], Pairs]] = {"bed": _bed, "spring": _spring}
