"""Rods on springs and beds, rods that touch and rub: reference/foundation.py, contact.py, friction.py."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import ancf
from ancf.rotation import log
from ancf.scene import Scene
from ancf.solution import Solution
from reference.contact import crossing_force, level_end_span, propped_force, wrapped_tip
from reference.foundation import (
    end_of_long_beam,
    propped_cantilever_tip,
    turned_cantilever_tip,
    turned_on_bed,
)
from reference.friction import belt_rate, pulled_end, rubbing_tip
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
    pairs = ANSWERS[case.parameters["kind"]](solution, case.parameters)
    rows = [Row(name, found, exact, unit) for name, found, exact, unit in pairs]
    observed = {name: abs(found / exact - 1.0) for name, found, exact, _ in pairs}
    if case.parameters["kind"] == "wrapped":
        observed = {"tip position": float(np.linalg.norm([found - exact for _, found, exact, _ in pairs]))}
    radius = solution.scene.rods[0].section.outer_radius
    for contact in solution.as_dict().get("contacts", []):
        observed["penetration"] = contact["penetration"] / radius
    return Outcome(observed, rows, solution, case.scene)


def _bed(solution: Solution, parameters: Mapping[str, Any]) -> Pairs:
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


def _spring(solution: Solution, parameters: Mapping[str, Any]) -> Pairs:
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


def _rotational_spring(solution: Solution, parameters: Mapping[str, Any]) -> Pairs:
    """A cantilever along x under a force along y on its end, which a spring keeps from turning."""
    scene = solution.scene
    (rod,), (load,), (spring,) = scene.rods, scene.forces, scene.springs
    k = float(spring.rotational_stiffness[2, 2])
    w, turn = turned_cantilever_tip(rod.length, _bending(scene), float(load.value[1]), k)
    tip = solution.tip()
    return [
        ("deflection", float(tip.position[1]), w, "m"),
        ("turn", float(tip.rotation[1, 0]), turn, "rad"),
    ]


def _rotational_bed(solution: Solution, parameters: Mapping[str, Any]) -> Pairs:
    """A rod along x that a couple on its end turns about the axis of that, twisted or bent, on a bed."""
    scene = solution.scene
    (rod,), (load,), (bed,) = scene.rods, scene.moments, scene.foundations
    size = float(np.linalg.norm(load.value))
    axis = load.value / size
    twisted = 2.0 * rod.material.lame_mu * rod.section.weaker_second_moment  # of a round rod, GJ
    stiffness = twisted if abs(axis[0]) > 0.5 else _bending(scene)
    pairs: Pairs = []
    for name, at in (("turn", 1.0), ("turn at 0.7 L", 0.7)):
        exact = turned_on_bed(
            [at * rod.length], rod.length, stiffness, float(bed.rotational_stiffness[0]), size
        )
        turn = float(log(solution.pose(None, at).rotation) @ axis)
        pairs.append((name, turn, float(exact[0]), "rad"))
    return pairs


def _bending(scene: Scene) -> float:
    rod = scene.rods[0]
    return rod.material.young_modulus * rod.section.weaker_second_moment


def _flat(solution: Solution, parameters: Mapping[str, Any]) -> Pairs:
    """A cantilever along x pressed onto a plane below by a line load along -z."""
    scene = solution.scene
    (rod,), (load,), (contact,) = scene.rods, scene.line_loads, solution.as_dict()["contacts"]
    assert scene.contacts[0].obstacle is not None
    w = -float(load.value[2])
    height = float(scene.contacts[0].obstacle.distance(np.zeros(3))[0]) - rod.section.outer_radius
    s = level_end_span(height, _bending(scene), w)
    force, moment = solution.reaction()
    return [
        ("reaction force", float(force[2]), 2.0 * w * s / 3.0, "N"),
        ("reaction moment", -float(moment[1]), w * s**2 / 6.0, "N m"),
        ("contact force", contact["force"][2], w * (rod.length - 2.0 * s / 3.0), "N"),
    ]


def _prop(solution: Solution, parameters: Mapping[str, Any]) -> Pairs:
    """A cantilever along x under a force along -z on its end, with a body below."""
    scene = solution.scene
    (rod,), (load,), (contact,) = scene.rods, scene.forces, solution.as_dict()["contacts"]
    at, clearance = parameters["at"] * rod.length, parameters["clearance"]
    exact = propped_force(rod.length, _bending(scene), -float(load.value[2]), at, clearance)
    return [("contact force", contact["force"][2], exact, "N")]


def _wrapped(solution: Solution, parameters: Mapping[str, Any]) -> Pairs:
    """A rod along x on top of a cylinder across it, under a force along -z on its end."""
    scene = solution.scene
    (rod,), (load,), (contact,) = scene.rods, scene.forces, scene.contacts
    assert contact.obstacle is not None
    rho = contact.obstacle.radius + rod.section.outer_radius
    end, _ = wrapped_tip(rod.length, _bending(scene), -float(load.value[2]), rho)
    tip = solution.tip().position
    return [("tip x", float(tip[0]), float(end[0]), "m"), ("tip z", -float(tip[2]), float(end[1]), "m")]


def _crossing(solution: Solution, parameters: Mapping[str, Any]) -> Pairs:
    """Two cantilevers whose ends cross; the first carries a force along -z on its end."""
    scene = solution.scene
    (upper, lower), (load,), (contact,) = scene.rods, scene.forces, solution.as_dict()["contacts"]
    EI = _bending(scene)
    exact = crossing_force(-float(load.value[2]), upper.length, EI, lower.length, EI)
    return [("contact force", contact["force"][2], exact, "N")]


def _rubbing_tip(solution: Solution, parameters: Mapping[str, Any]) -> Pairs:
    """A cantilever along x, its end pressed on a plane along -z and pushed along y."""
    scene = solution.scene
    (rod,), (load,), (contact,) = scene.rods, scene.forces, solution.as_dict()["contacts"]
    mu, EI = scene.contacts[0].friction, _bending(scene)
    normal = propped_force(rod.length, EI, -float(load.value[2]), rod.length, parameters["clearance"])
    way = rubbing_tip(rod.length, EI, float(load.value[1]), mu, normal)
    return [
        ("friction force", -contact["friction"]["force"][1], mu * normal, "N"),
        ("way of the tip", float(solution.tip().position[1]), way, "m"),
    ]


def _pulled(solution: Solution, parameters: Mapping[str, Any]) -> Pairs:
    """A rod along x, pressed on a plane by a line load and pulled along it by its end."""
    scene = solution.scene
    (rod,), (load,), (weight,) = scene.rods, scene.forces, scene.line_loads
    axial = rod.material.young_modulus * rod.section.area
    held = -scene.contacts[0].friction * float(weight.value[2])
    _, way = pulled_end(float(load.value[0]), held, axial)
    return [("way of the end", float(solution.tip().position[0]) - rod.length, way, "m")]


def _inclined(solution: Solution, parameters: Mapping[str, Any]) -> Pairs:
    """A free rod at rest on a plane, seen in its axes."""
    scene = solution.scene
    (rod,), (contact,) = scene.rods, solution.as_dict()["contacts"]
    assert scene.gravity is not None and rod.material.density is not None
    weight = rod.material.density * rod.section.area * rod.length * scene.gravity.acceleration
    return [
        ("friction force", -contact["friction"]["force"][0], float(weight[0]), "N"),
        ("contact force", contact["force"][2], -float(weight[2]), "N"),
    ]


def _belt(solution: Solution, parameters: Mapping[str, Any]) -> Pairs:
    """A rod that slips round a cylinder as its own shape, away from both ends."""
    (contact,) = solution.scene.contacts
    assert contact.obstacle is not None
    forces = solution.section_forces()
    tension = np.einsum("ia,ia->i", forces.force, solution.section_axes()[:, :, 0])
    inside = (forces.at > 0.2) & (forces.at < 0.8)
    rate = -float(np.polyfit(forces.x[inside], np.log(tension[inside]), 1)[0])
    rho = 1.0 / float(np.linalg.norm(solution.scene.rods[0].curvature))
    return [("rate of tension", rate, belt_rate(contact.friction, contact.obstacle.radius, rho), "1/m")]


ANSWERS: dict[str, Callable[[Solution, Mapping[str, Any]], Pairs]] = {
    "bed": _bed,
    "spring": _spring,
    "rotational spring": _rotational_spring,
    "rotational bed": _rotational_bed,
    "flat": _flat,
    "prop": _prop,
    "wrapped": _wrapped,
    "crossing": _crossing,
    "rubbing tip": _rubbing_tip,
    "pulled": _pulled,
    "inclined": _inclined,
    "belt": _belt,
}
