"""The beam against section problem, 3-D solid and rod: the tip's pose, and the rate of what remains."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference.rotation import exp, log
from validation.cases import Case
from validation.exact import Answer, answer
from validation.outcome import Outcome, Row
from validation.scenes import changed, in_si, solve, stiffness_of

Floats = NDArray[np.float64]

# M L/EI of a moment that bends about two axes and twists: the load case of the paper's data set.
BOTH = (0.6, 0.5, -0.8)
GRAVITY = 9.81  # m/s2


def loaded(scene: Mapping[str, Any], load: str, size: float) -> dict[str, Any]:
    """The scene with one load of a family, in SI.

    ``bending``: M = E I theta/L about z with `size` theta in degrees; ``torsion``: M = G J theta/L about x;
    ``bending and torsion``: M = `size` (0.6, 0.5, -0.8) E I/L; ``tip force``: `size` E I/L^2 along y;
    ``gravity``: `size` times 9.81 m/s2 along -y. Forces across the rod lie along y, which the
    solid's soft clamp asks for.
    """
    numbers = stiffness_of(scene)
    if load == "bending":
        moment = [0.0, 0.0, math.radians(size)]
    elif load == "torsion":
        moment = [math.radians(size) * numbers.GJ / numbers.EI, 0.0, 0.0]
    elif load == "bending and torsion":
        moment = [size * v for v in BOTH]
    elif load == "tip force":
        return in_si(changed(scene, force=[{"value": [0.0, size, 0.0]}]))
    elif load == "gravity":
        return changed(scene, gravity={"acceleration": [0.0, -size * GRAVITY, 0.0]})
    else:
        raise ValueError(f"there is no load family {load!r}")
    return in_si(changed(scene, moment=[{"value": moment}]))


def cross_check(case: Case) -> Outcome:
    """Tip position [L] and rotation [rad] for each size of the load against each reference named."""
    load, against = case.parameters["load"], case.parameters["against"]
    observed, errors, rows, notes = {}, {}, [], []
    solution = scene = None
    for size in case.parameters["sizes"]:
        scene = loaded(case.scene, load, size)
        solution = solve(scene)
        tip = solution.tip()
        length = case.rod["length"]
        for source in against:
            exact = answer(source, scene, case.parameters.get("support", "soft"))
            label = f"{size:g}, {source}"
            found = tip.position / length
            deviation = {
                f"tip position, {label}": (
                    float(np.linalg.norm(found - exact.position)),
                    exact.position_error,
                ),
                f"tip rotation, {label}": (turn_between(tip.rotation, exact.rotation), exact.angle_error),
            }
            for name, (value, own) in deviation.items():
                observed[name], errors[name] = value, own
            rows += [
                Row(f"{label}: tip {axis}/L", float(a), _number(b), "-")
                for axis, a, b in zip("xyz", found, exact.position, strict=True)
            ]
            if exact.reason:
                notes.append(f"{label}: {exact.reason}")
    return Outcome(observed, rows, solution, scene, errors, notes)


def gap_rate(case: Case) -> Outcome:
    """Order in R of the tip's distance from the section problem, at the same angle and length.

    What remains between a beam and the exact answer when the mesh is fine is the beam's model error, and it
    has to vanish as (kappa R)^2. Observed: the distance of the fitted order from 2, and the coefficient c of
    the tip's distance, c (kappa R)^2 L.
    """
    load, size = case.parameters["load"], case.parameters["sizes"][0]
    gaps, own, strains, rows = [], [], [], []
    solution = scene = None
    for radius in case.parameters["radii"]:
        scene = loaded(changed(case.scene, {"section": {"shape": "circle", "radius": radius}}), load, size)
        solution = solve(scene)
        exact = answer("section", scene)
        if exact.reason:
            return Outcome({QUANTITY_ORDER: math.nan, QUANTITY_SIZE: math.nan}, rows, solution, scene,
                           {QUANTITY_ORDER: math.inf, QUANTITY_SIZE: math.inf}, [exact.reason])  # fmt: skip
        length = case.rod["length"]
        gaps.append(float(np.linalg.norm(solution.tip().position / length - exact.position)))
        own.append(exact.position_error)
        strains.append(float(np.linalg.norm(scene["moment"][0]["value"])) / stiffness_of(scene).EI * radius)
        rows.append(Row(f"distance/L at kappa R = {strains[-1]:.4f}", gaps[-1], 0.0, "-"))
    order = float(np.polyfit(np.log(strains), np.log(gaps), 1)[0])
    coefficient = gaps[-1] / strains[-1] ** 2
    rows += [Row("fitted order", order, 2.0, "-"), Row("c", coefficient, None, "-")]
    # An error d of the smallest gap moves the fitted order by about d / gap / ln(range of R).
    slack = own[-1] / gaps[-1] / math.log(strains[0] / strains[-1])
    return Outcome(
        {QUANTITY_ORDER: abs(order - 2.0), QUANTITY_SIZE: coefficient},
        rows,
        solution,
        scene,
        {QUANTITY_ORDER: slack, QUANTITY_SIZE: own[-1] / strains[-1] ** 2},
    )


QUANTITY_ORDER = "order of the distance in R, from 2"
QUANTITY_SIZE = "distance by (kappa R)^2"


def ladder(case: Case) -> Outcome:
    """The references against each other: solid against section problem, no beam."""
    load = case.parameters["load"]
    observed, errors, rows, notes = {}, {}, [], []
    scene = None
    for size in case.parameters["sizes"]:
        scene = loaded(case.scene, load, size)
        exact = answer("section", scene)
        solid = answer("solid", scene, case.parameters.get("support", "soft"))
        whole = float(np.linalg.norm(scene["moment"][0]["value"])) / stiffness_of(scene).EI
        whole *= float(case.rod["length"])
        compared = {"tip": (solid.rotation, exact.rotation, solid.angle_error)}
        if solid.values and exact.values:
            third = np.array(solid.values["third"])
            compared["middle third"] = (third, _third_of(exact), solid.values["third_error"])
        for place, (found, wanted, own) in compared.items():
            name = f"turn of {place} by the angle, {size:g}"
            observed[name] = turn_between(found, wanted) / whole
            errors[name] = (own + exact.angle_error) / whole
            rows.append(Row(f"{size:g}: {place}, solid against section", _number(observed[name]), 0.0, "-"))
        rows.append(Row(f"{size:g}: unknowns of the finest solid", solid.values.get("unknowns"), None, "-"))
        notes += [f"{size:g}: {a.reason}" for a in (exact, solid) if a.reason]
    return Outcome(observed, rows, None, scene, errors, notes)


def _third_of(exact: Answer) -> Floats:
    """Rotation (3, 3) of the section at 2/3 of the length against that at 1/3, by the section problem."""
    screw = np.array(exact.values["screw"])
    spin = exact.values["twist"] - screw[0]
    at = [exp(s * screw) @ exp(np.array([s * spin, 0.0, 0.0])) for s in (1 / 3, 2 / 3)]
    return at[1] @ at[0].T


def turn_between(found: Floats, exact: Floats) -> float:
    """Angle [rad] between two rotations (3, 3); nan where one is not known."""
    if not np.all(np.isfinite(exact)) or not np.all(np.isfinite(found)):
        return math.nan
    return float(np.linalg.norm(log(found @ exact.T)))


def _number(value: Any) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)


__all__ = ["Answer", "cross_check", "gap_rate", "ladder", "loaded", "turn_between"]
