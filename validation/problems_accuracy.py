"""Problems of `accuracy`: is the estimated tip error right, and is the wanted one met, against other answers?

Thin rods: the error of the mesh against the helix, the integrated rod or a quadrature. They are so slender
that the finite strain of the beam, which those references do not have, is three hundredths of the least
accuracy wanted of them. Thick rods: the known error of the sections against the exact section problem.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.scene import Scene
from ancf.solution import Solution
from reference.helix import helix_tip_moment
from reference.rod import solve_rod
from reference.section_answer import section_answer
from validation.cases import Case
from validation.outcome import Outcome, Row
from validation.scenes import LOAD_UNITS, NoEquilibrium, Stiffness, reference_rod

Floats = NDArray[np.float64]

# What finite strain moves the tip by, over length, in (kappa R)^2 (README, table of the elements).
FINITE_STRAIN = 1.0
POINTS, PIECES = 8, 64  # Gauss points and intervals in each segment of the quadrature


def estimated_error(case: Case) -> Outcome:
    """Estimate of the tip error and the tip error itself, for the `accuracies` of the parameters.

    `reference` in the parameters names the answer, of `REFERENCES`.
    """
    scene = in_units(case.scene)
    observed, errors, rows = {}, {}, []
    solution = None
    for wanted in case.parameters["accuracies"]:
        solution = _solved(scene, wanted)
        accuracy = solution.accuracy
        assert accuracy is not None and accuracy.estimate is not None
        exact, uncertainty = REFERENCES[case.parameters["reference"]](solution.scene)
        rod = solution.scene.rods[0]
        tip = solution.tip().position
        error = float(np.linalg.norm(tip - exact)) / rod.length
        uncertainty += FINITE_STRAIN * _largest_strain(solution) ** 2
        excess, ratio = f"beyond the accuracy, {wanted:g}", f"effectivity, {wanted:g}"
        observed[excess] = max(error / wanted - 1.0, 0.0)
        errors[excess] = uncertainty / wanted
        observed[ratio] = max(accuracy.estimate / error, error / accuracy.estimate)
        errors[ratio] = uncertainty / error
        mesh = f"{rod.elements} x {rod.element}"
        rows.append(Row(f"accuracy {wanted:g}: estimate beside error, {mesh}", accuracy.estimate, error, "L"))
    return Outcome(observed, rows, solution, {**scene, "solver": {"accuracy": wanted}}, errors)


def model_error(case: Case) -> Outcome:
    """Known error of the sections beside the distance of a fine beam from the exact section problem."""
    scene = in_units(case.scene)
    wanted = float(case.parameters["accuracy"])
    solution = _solved(scene, wanted)
    accuracy = solution.accuracy
    assert accuracy is not None and accuracy.estimate is not None and accuracy.model_error is not None
    rod, load = scene["rod"][0], scene["moment"][0]["value"]
    exact = section_answer(rod["material"], rod["section"], rod["length"], load)
    error = float(np.linalg.norm(solution.tip().position / rod["length"] - exact["position"]))
    uncertainty = exact["position_error"] + accuracy.estimate
    observed = {"model effectivity": max(accuracy.model_error / error, error / accuracy.model_error)}
    chosen = solution.scene.rods[0]
    row = Row(
        f"model error beside error, {chosen.elements} x {chosen.element}", accuracy.model_error, error, "L"
    )
    return Outcome(
        observed, [row], solution, {**scene, "solver": {"accuracy": wanted}},
        {"model effectivity": uncertainty / error},
    )  # fmt: skip


def _solved(scene: Mapping[str, Any], wanted: float) -> Solution:
    solution = ancf.solve(ancf.scene_from_dict({**scene, "solver": {"accuracy": wanted}}))
    if solution.status is not ancf.Status.CONVERGED:
        raise NoEquilibrium(f"{solution.status}: {solution.reason}")
    return solution


def in_units(scene: Mapping[str, Any]) -> dict[str, Any]:
    """The scene with loads given in E I/L, E I/L^2 or E I/L^3 of the section at the base turned into SI."""
    copied = copy.deepcopy(dict(scene))
    rod = Stiffness.of(ancf.scene_from_dict({"rod": copied["rod"], "solver": {"accuracy": 0.1}}).rods[0])
    for table, power in LOAD_UNITS.items():
        for entry in copied.get(table, []):
            entry["value"] = [float(v) * rod.EI / rod.length**power for v in entry["value"]]
    return copied


def _largest_strain(solution: Solution) -> float:
    """kappa R, the largest along the rod, from the section moments."""
    rod = solution.scene.rods[0]
    forces = solution.section_forces()
    strain = []
    for at, moment in zip(forces.at, np.linalg.norm(forces.moment, axis=1), strict=True):
        section = rod.section_at(float(at))
        young = rod.parts[rod.part_at(float(at))].material.young_modulus
        strain.append(moment * section.outer_radius / (young * section.weaker_second_moment))
    return float(max(strain))


def _helix(scene: Scene) -> tuple[Floats, float]:
    """Tip of a plain round rod under one tip moment, in closed form."""
    rod, numbers = scene.rods[0], Stiffness.of(scene.rods[0])
    exact = helix_tip_moment(scene.moments[0].value, rod.length, numbers.EI, numbers.GJ, rod.length)
    return exact.position[0], 0.0


def _rod(scene: Scene) -> tuple[Floats, float]:
    """Tip of a plain rod by collocation of the rod equations."""
    properties, loads = reference_rod(scene)
    exact = solve_rod(properties, loads)
    return exact.position[0], exact.estimated_error


def _point_force(scene: Scene) -> tuple[Floats, float]:
    """Tip of a plain straight rod under a dead force short of its tip: integrated so far, straight beyond."""
    rod, force = scene.rods[0], scene.forces[0]
    loaded = replace(rod, length=force.at * rod.length, breaks=())
    properties, loads = reference_rod(replace(scene, rods=(loaded,), forces=(replace(force, at=1.0),)))
    exact = solve_rod(properties, loads)
    beyond = (1.0 - force.at) * rod.length * exact.frame[0][:, 0]
    return exact.position[0] + beyond, exact.estimated_error


def _couple(scene: Scene) -> tuple[Floats, float]:
    """Tip of a straight rod of segments under a couple about z: theta' = M/(E I), r' = e(theta)."""
    M = float(scene.moments[0].value[2])
    xi, weight = np.polynomial.legendre.leggauss(POINTS)
    theta, tip = 0.0, np.zeros(3)
    for part in scene.rods[0].parts:
        h = part.length / PIECES
        for piece in range(PIECES):

            def curvature(s: Floats, start: float = piece / PIECES, part: Any = part) -> Floats:
                sections = [part.section_at(start + value / PIECES) for value in s]
                return M / (
                    part.material.young_modulus * np.array([c.second_moments[0, 0] for c in sections])
                )

            s = 0.5 * (1.0 + xi)
            turns = [theta + 0.5 * h * end * float(weight @ curvature(s * end)) for end in s]
            tip += 0.5 * h * np.array([weight @ np.cos(turns), weight @ np.sin(turns), 0.0])
            theta += 0.5 * h * float(weight @ curvature(s))
    return tip, 1e-13


REFERENCES: dict[str, Callable[[Scene], tuple[Floats, float]]] = {
    "helix": _helix,
    "rod": _rod,
    "point force": _point_force,
    "couple": _couple,
}
