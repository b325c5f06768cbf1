"""Problems under a tip moment: helix, pure bending, bending and torsional stiffness, the "
"vorticity moment's defect."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference import analytic
from validation.cases import Case
from validation.criteria import largest
from validation.outcome import Outcome, Row
from validation.scenes import (
    bending_angle,
    changed,
    in_si,
    solve,
    stiffness_of,
    twist_angle,
    with_poisson_ratio,
)

Floats = NDArray[np.float64]

# A turn this small keeps finite-strain terms, of order (angle R/L)^2, below 1e-11.
SMALL_ANGLE = 1e-4


def helix(case: Case) -> Outcome:
    """Round rod under a tip moment against the closed-form helix: tip position, section axes, m(s) = M.

    With `free_of_strain` in the parameters only the position is compared.
    """
    scene = in_si(case.scene)
    solution = solve(scene)
    rod, load = solution.scene.rods[0], solution.scene.moments[0]
    numbers = stiffness_of(scene)
    A_o = rod.base.rotation
    exact = analytic.helix_tip_moment(
        load.value, numbers.length, numbers.EI, numbers.GJ, numbers.length, A_o[:, 0], load.direction
    )
    tip = solution.tip()
    position = tip.position - rod.base.position
    sections = exact.rotation[0] @ A_o
    observed = {
        "tip position": float(np.linalg.norm(position - exact.position[0]) / numbers.length),
        "tip r_y, r_z": largest(
            float(np.linalg.norm(tip.r_y - sections[:, 1])), float(np.linalg.norm(tip.r_z - sections[:, 2]))
        ),
    }
    if load.direction == "fixed":
        moment = solution.section_forces().moment
        observed["section moment along the rod"] = float(
            np.max(np.linalg.norm(moment - load.value, axis=1)) / np.linalg.norm(load.value)
        )
        reaction = solution.reaction()[1]
        observed["reaction moment"] = float(
            np.linalg.norm(reaction + load.value) / np.linalg.norm(load.value)
        )
    wanted = {limit.quantity for limit in case.limits}
    rows = [
        Row(f"tip {axis}", float(a), float(b), "m")
        for axis, a, b in zip("xyz", position, exact.position[0], strict=True)
    ]
    return Outcome({k: v for k, v in observed.items() if k in wanted}, rows, solution, scene)


def pure_bending(case: Case) -> Outcome:
    """Tip angle under a moment about z against the finite-strain closed form (section free to stretch)."""
    observed, rows = {}, []
    numbers = stiffness_of(case.scene)
    solution = scene = None
    for share in case.parameters["angles_over_pi"]:
        theta = share * np.pi
        moment = numbers.EI * theta / numbers.length
        section = analytic.BendingSection.circle(numbers.radius)
        young_modulus = case.rod["material"]["young_modulus"]
        exact = analytic.pure_bending_curvature(moment, young_modulus, section).curvature * numbers.length
        scene = changed(case.scene, moment=[{"value": [0.0, 0.0, moment]}])
        solution = solve(scene)
        found = bending_angle(solution.tip().rotation, exact)
        name = f"tip angle at M L/EI = {share:g} pi"
        observed[name] = abs(found / exact - 1.0)
        rows.append(Row(f"kappa L/theta, theta = {share:g} pi", found / theta, exact / theta, "-"))
    return Outcome(observed, rows, solution, scene)


def bending_stiffness(case: Case) -> Outcome:
    """EI_eff/EI from a tiny tip moment, for several Poisson ratios and bases, against the "
    "locking factor or 1."""
    observed, rows = {}, []
    solution = scene = None
    for nu in case.parameters["poisson_ratios"]:
        material = with_poisson_ratio(case.rod["material"], nu)
        numbers = stiffness_of(changed(case.scene, {"material": material}))
        moment = SMALL_ANGLE * numbers.EI / numbers.length
        locked = case.rod["formulation"] == "continuum" and case.rod["element"] != "3363"
        exact = analytic.full_hooke_locking_factor(nu) if locked else 1.0
        for name, base in case.parameters["bases"].items():
            rod = {"material": material, "base": base}
            scene = changed(case.scene, rod, moment=[{"value": [0.0, 0.0, moment], "frame": "body"}])
            solution = solve(scene)
            A_o = solution.scene.rods[0].base.rotation
            ratio = SMALL_ANGLE / bending_angle(A_o.T @ solution.tip().rotation @ A_o, 0.0)
            observed[f"EI ratio, nu = {nu:g}, {name}"] = abs(ratio / exact - 1.0)
            rows.append(Row(f"EI_eff/EI, nu = {nu:g}, {name}", ratio, exact, "-"))
    return Outcome(observed, rows, solution, scene)


def torsion_stiffness(case: Case) -> Outcome:
    """Torsion constant from a tiny tip torque against the exact one of Saint-Venant."""
    shape = case.rod["section"]
    if shape["shape"] == "circle":
        exact = analytic.torsion_constant_circle(shape["radius"])
    elif shape["shape"] == "ellipse":
        exact = analytic.torsion_constant_ellipse(shape["semi_axis_y"], shape["semi_axis_z"])
    else:
        exact = analytic.torsion_constant_rectangle(shape["height_y"], shape["width_z"])
    material = case.rod["material"]
    GJ = material["young_modulus"] / (2.0 * (1.0 + material["poisson_ratio"])) * exact
    length = case.rod["length"]
    moment = SMALL_ANGLE * GJ / length
    scene = changed(case.scene, moment=[{"value": [moment, 0.0, 0.0]}])
    solution = solve(scene)
    ratio = SMALL_ANGLE / twist_angle(solution.tip().rotation)
    rows = [Row("J", ratio * exact, exact, "m4"), Row("J/J_exact", ratio, 1.0, "-")]
    return Outcome({"torsion constant": abs(ratio - 1.0)}, rows, solution, scene)


def vorticity_angle(case: Case) -> Outcome:
    """Spurious turn of r_x at the tip under the paper's moment, against 3 sqrt(2) M/(k G A h) for 3243.

    r_x is compared with the normal of its own section, so bending itself drops out.
    """
    observed, rows = {}, []
    numbers = stiffness_of(case.scene)
    angle = case.parameters["angle"]
    moment = angle * numbers.EI / numbers.length
    GA = 2.0 * numbers.GJ / numbers.radius**2  # G J = G A R^2/2 of a circle
    solution = scene = None
    for elements in case.parameters["elements"]:
        definition = case.parameters["definition"]
        scene = changed(
            case.scene,
            {"elements": elements},
            moment=[{"value": [0.0, 0.0, moment], "definition": definition}],
        )
        solution = solve(scene)
        tip = solution.tip()
        turn = float(np.arctan2(tip.r_x[1], tip.r_x[0])) - bending_angle(tip.rotation, angle)
        predicted = 3.0 * np.sqrt(2.0) * moment / GA * elements / numbers.length
        observed[f"turn of r_x, {elements} elements"] = abs(turn)
        reference = predicted if definition == "vorticity" else 0.0
        rows.append(Row(f"turn of r_x, {elements} elements", turn, reference, "rad"))
    return Outcome(observed, rows, solution, scene)
