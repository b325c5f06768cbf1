"""Problems under forces: elastica, any rod against the integrated rod, published displacements, "
"uniaxial stretch."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reference import analytic
from reference.homogeneous import (
    principal_mooney_rivlin,
    principal_neo_hookean,
    uniaxial as homogeneous_uniaxial,
)
from reference.rod import solve_rod
from validation.cases import Case
from validation.criteria import largest
from validation.outcome import Outcome, Row
from validation.scenes import (
    bending_angle,
    changed,
    in_si,
    reference_rod,
    solve,
    stiffness_of,
    young_modulus,
)


def elastica(case: Case) -> Outcome:
    """Cantilever under a transverse tip force against the elliptic integrals, several loads."""
    observed, rows = {}, []
    numbers = stiffness_of(case.scene)
    solution = scene = None
    for load in case.parameters["loads"]:
        exact = analytic.elastica_tip_force(load)
        force = load * numbers.EI / numbers.length**2
        scene = changed(case.scene, force=[{"value": [0.0, force, 0.0]}])
        solution = solve(scene)
        tip = solution.tip()
        u, w = 1.0 - tip.position[0] / numbers.length, tip.position[1] / numbers.length
        theta = bending_angle(tip.rotation, exact.angle)
        name = f"worst of u/L, w/L, theta at P L2/EI = {load:g}"
        observed[name] = largest(abs(u - exact.u), abs(w - exact.w), abs(theta - exact.angle))
        label = f"P L2/EI = {load:g}"
        rows += [
            Row(f"{label}: u/L", float(u), exact.u, "-"),
            Row(f"{label}: w/L", float(w), exact.w, "-"),
            Row(f"{label}: theta", theta, exact.angle, "rad"),
        ]
    return Outcome(observed, rows, solution, scene)


def rod(case: Case) -> Outcome:
    """Any clamped rod against the Simo-Reissner rod integrated in reference/: tip position and rotation.

    `length_scale` in the parameters replaces the rod length as the unit of the position error (an arc
    radius).
    `tip` among the printed values of the reference is compared as well, relative to the length scale.
    """
    scene = in_si(case.scene) if case.parameters.get("dimensionless", True) else case.scene
    solution = solve(scene)
    properties, loads = reference_rod(solution.scene)
    exact = solve_rod(properties, loads)
    scale = float(case.parameters.get("length_scale", properties.length))
    tip = solution.tip()
    turn = tip.rotation @ exact.rotation[0].T
    angle = float(
        np.linalg.norm([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2.0
    )
    observed = {
        "tip position": float(np.linalg.norm(tip.position - exact.position[0]) / scale),
        "tip rotation": angle,
        "deflection": float(
            abs(tip.position[1] - exact.position[0][1]) / max(abs(exact.position[0][1]), 1e-300)
        ),
    }
    rows = [
        Row(f"tip {axis}", float(a), float(b), "m")
        for axis, a, b in zip("xyz", tip.position, exact.position[0], strict=True)
    ]
    errors = {
        "tip position": exact.estimated_error * properties.length / scale,
        "tip rotation": exact.estimated_error,
    }
    printed = case.reference.values.get("tip")
    if printed is not None:
        observed["tip against printed values"] = float(np.max(np.abs(tip.position - printed)) / scale)
        observed["integrated rod against printed values"] = float(
            np.max(np.abs(exact.position[0] - printed)) / scale
        )
        errors["integrated rod against printed values"] = exact.estimated_error * properties.length / scale
    literature = case.reference.values.get("literature")
    if literature is not None:
        deviation = np.abs(tip.position - literature) / np.abs(literature)
        observed["tip against literature"] = float(np.max(deviation))
        rows += [
            Row(f"tip {axis}, literature", float(a), float(b), "m")
            for axis, a, b in zip("xyz", tip.position, literature, strict=True)
        ]
    wanted = {limit.quantity for limit in case.limits}
    return Outcome({k: v for k, v in observed.items() if k in wanted}, rows, solution, scene, errors)


def published_deflection(case: Case) -> Outcome:
    """Tip deflection u_y against a published number."""
    solution = solve(case.scene)
    printed = float(case.reference.values["u_y"])
    found = float(solution.tip().position[1])
    errors = {"tip deflection": float(case.reference.values["rounding"]) / abs(printed)}
    rows = [Row("u_y", found, printed, "m")]
    return Outcome({"tip deflection": abs(found / printed - 1.0)}, rows, solution, case.scene, errors)


def uniaxial(case: Case) -> Outcome:
    """Axial stretch and contraction under a tip force, section free at the support, against the "
    "closed form."""
    observed, rows = {}, []
    solution = scene = None
    numbers = stiffness_of(case.scene)
    for nu in case.parameters["poisson_ratios"]:
        material = {**case.rod["material"], "poisson_ratio": nu}
        area = numbers.EA / material["young_modulus"]
        for share in case.parameters["forces_over_EA"]:
            exact = analytic.uniaxial_saint_venant_kirchhoff(
                share * numbers.EA, material["young_modulus"], nu, area
            )
            scene = changed(
                case.scene, {"material": material}, force=[{"value": [share * numbers.EA, 0.0, 0.0]}]
            )
            solution = solve(scene)
            tip = solution.tip()
            axial, lateral = tip.position[0] / numbers.length, float(np.linalg.norm(tip.r_y))
            label = f"F/EA = {share:g}, nu = {nu:g}"
            observed[f"stretch, {label}"] = largest(
                abs(axial / exact.axial - 1.0), abs(lateral / exact.lateral - 1.0)
            )
            rows += [
                Row(f"{label}: axial stretch", float(axial), exact.axial, "-"),
                Row(f"{label}: lateral stretch", lateral, exact.lateral, "-"),
            ]
    return Outcome(observed, rows, solution, scene)


def rubber_stretch(case: Case) -> Outcome:
    """Stretch of a rubber rod under the axial force that its law needs for it, lateral stress zero.

    `stretches` are imposed through the exact nominal stress; with `incompressible` the force [N] is given and
    the stretch is that of the incompressible neo-Hookean bar, mu (lambda - 1/lambda^2) = F/A.
    """
    observed, rows = {}, []
    solution = scene = None
    area = stiffness_of(case.scene).EA / young_modulus(case.rod["material"])
    for name, wanted, force in _stretches(case, area):
        scene = changed(case.scene, force=[{"value": [force, 0.0, 0.0]}])
        solution = solve(scene)
        tip = solution.tip()
        axial, lateral = tip.position[0] / case.rod["length"], float(np.linalg.norm(tip.r_y))
        observed[f"stretch, {name}"] = largest(abs(axial / wanted[0] - 1.0), abs(lateral / wanted[1] - 1.0))
        rows += [
            Row(f"{name}: axial stretch", float(axial), wanted[0], "-"),
            Row(f"{name}: lateral stretch", lateral, wanted[1], "-"),
        ]
    return Outcome(observed, rows, solution, scene)


def _stretches(case: Case, area: float) -> Iterator[tuple[str, tuple[float, float], float]]:
    """Name, (axial, lateral) stretch and force [N] of every load of a rubber case."""
    material = case.rod["material"]
    if "incompressible" in case.parameters:
        force, mu = case.parameters["incompressible"]["force"], case.parameters["incompressible"]["mu"]
        stretch = float(np.roots([mu, -force / area, 0.0, -mu])[0].real)
        yield f"F = {force:g} N, incompressible", (stretch, stretch**-0.5), force
        return
    if material["law"] == "neo-hookean":
        stress = principal_neo_hookean(material["young_modulus"], material["poisson_ratio"])
    else:
        stress = principal_mooney_rivlin(material["c10"], material["c01"], material["bulk_modulus"])
    for stretch in case.parameters["stretches"]:
        state = homogeneous_uniaxial(stress, stretch)
        yield f"{stretch:g}", (stretch, state.free), state.stress * area
