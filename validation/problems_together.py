"""Rods under several effects at once, against the rod integrated with all of them in reference/."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ancf.scene import Scene
from reference.actuated_rod import solve_actuated_rod
from reference.cache import session
from reference.rod import RodProperties
from reference.rod_actions import Bed, PointAction, RodActions, Wire
from reference.rod_inputs import constants_of
from reference.rotation import log
from reference.round_law import RoundLaw, fitted_numbers
from validation.cases import Case
from validation.load_numbers import MU_0, in_units
from validation.outcome import Outcome, Row
from validation.scenes import reference_rod, solve


def actuated_rod(case: Case) -> Outcome:
    """Tip position [L] and rotation [rad] of a straight round rod; loads are numbers, times a `share`.

    The section follows the exact section problem to the order that finite strain adds; what the next order
    would add, (kappa R)^4 and (N/EA)^2, counts as error of the reference.
    """
    scene = in_units(case.scene, case.parameters.get("share", 1.0))
    solution = solve(scene)
    rod = solution.scene.rods[0]
    properties, actions = actions_of(solution.scene)
    exact = solve_actuated_rod(properties, actions, _law(scene["rod"][0]["material"]))
    forces = solution.section_forces()
    kappa_R = float(np.linalg.norm(forces.moment, axis=1).max()) * rod.section.outer_radius / properties.EI_y
    thrust = float(np.linalg.norm(forces.force, axis=1).max()) / properties.EA
    own = kappa_R**4 + thrust**2
    tip = solution.tip()
    observed = {
        "tip position": float(np.linalg.norm(tip.position - exact.position)) / rod.length,
        "tip rotation": float(np.linalg.norm(log(tip.rotation @ exact.rotation.T))),
    }
    errors = {
        "tip position": exact.position_error / rod.length + own,
        "tip rotation": exact.angle_error + own,
    }
    rows = [
        Row(f"tip {axis}", float(a), float(b), "m")
        for axis, a, b in zip("xyz", tip.position, exact.position, strict=True)
    ]
    rows += [Row("kappa R", kappa_R, None, "-"), Row("N/EA", thrust, None, "-")]
    return Outcome(observed, rows, solution, scene, errors)


def actions_of(scene: Scene) -> tuple[RodProperties, RodActions]:
    """The same rod and loads for the reference; only numbers pass, no code."""
    (rod,) = scene.rods
    properties, _ = reference_rod(_bare(scene))
    points = []
    for load in scene.forces:
        name = "follower_force" if load.direction == "follower" else "force"
        points.append(PointAction(load.at, load.offset, **{name: load.value}))
    for load in scene.moments:
        name = "follower_moment" if load.direction == "follower" else "moment"
        points.append(PointAction(load.at, **{name: load.value}))
    for spring in scene.springs:
        if spring.anchor is not None:
            raise ValueError("the reference rod takes springs to the reference only")
        points.append(PointAction(spring.at, spring.offset, spring=spring.stiffness))
    wires = []
    for tendon in scene.tendons:
        if tendon.tension is None or tendon.friction:
            raise ValueError("the reference rod takes tendons of given tension without friction only")
        wires.append(Wire(tendon.tension, tendon.path))
    for chamber in scene.pressures:
        path = [[at, *chamber.centre] for at in (chamber.start, chamber.end)]
        wires.append(Wire(-chamber.value * math.pi * chamber.radius**2, path, normal=True))
    base = rod.base.rotation
    beds = []
    for bed in scene.foundations:
        axes = base if bed.axes is None else bed.axes
        beds.append(Bed((axes * bed.stiffness) @ axes.T, bed.start, bed.end))
    line = {"line_force": np.zeros(3), "follower_line_force": np.zeros(3),
            "line_moment": np.zeros(3), "follower_line_moment": np.zeros(3)}  # fmt: skip
    for kind, loads in (("line_force", scene.line_loads), ("line_moment", scene.line_moments)):
        for load in loads:
            name = f"follower_{kind}" if load.direction == "follower" else kind
            line[name] = line[name] + load.value
    if scene.gravity is not None:
        weight = (rod.material.density or 0.0) * rod.section.area * scene.gravity.acceleration
        line["line_force"] = line["line_force"] + weight
    magnets = tuple((rod.section.area / MU_0 * m.remanence, m.field) for m in scene.magnets)
    return properties, RodActions(tuple(points), tuple(wires), tuple(beds), **line, magnets=magnets)


def _bare(scene: Scene) -> Scene:
    return Scene(rods=scene.rods)


def _law(material: Mapping[str, Any]) -> RoundLaw:
    """What finite strain adds to the stiffness of a law, from the store; E counts as 1."""
    constants = {**constants_of(material, "law"), "young_modulus": 1.0}
    return RoundLaw(**session().get("round_law", constants, lambda: fitted_numbers(constants)))
