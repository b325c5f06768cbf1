"""The references themselves on the axes of the beams: 3-D solid, exact section problem, integrated rod.

What a reference costs when it is not stored, timed live, mostly once. Only rods bent by a couple have a solid
here: others would need too long.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import ancf
from reference.rod import RodNotSolved, solve_rod
from reference.rod_inputs import law_of, section_of
from reference.section import SectionState, bend, bend_and_twist
from reference.section_answer import CELLS
from reference.solid import (
    SolidProblem,
    SolidResult,
    bent_rod,
    formulation_for,
    rod_mesh,
    soft_clamp,
    solve_solid,
)
from validation.cost.families import Family, Reference
from validation.cost.points import CostPoint, timed
from validation.scenes import changed, reference_rod, stiffness_of

# Cells across the core of the section, slices: some 1e-3 and 1e-4 of the angle at L/R = 40 and 90 degrees.
SOLID_MESHES = ((2, 20),)
SOLID_MESHES_FULL = ((1, 10), (2, 20), (3, 40))


def reference_points(family: Family, reference: Reference, full: bool) -> Iterator[CostPoint]:
    """Measure what can be measured of a family's references; `absent_references` says what cannot."""
    if reference.kind == "exact solid":
        yield _section(family, reference)
    if reference.kind == "rod":
        yield _rod(family, reference)
    if _bends_only(family):
        for cells, slices in SOLID_MESHES_FULL if full else SOLID_MESHES:
            yield _solid(family, reference, cells, slices)


def absent_references(family: Family, reference: Reference) -> list[str]:
    """Why a solid, or a section problem, is not on the axes of a family."""
    reasons = []
    if not _bends_only(family):
        reasons.append(
            "solid hex27: timed in pure bending only; slender or wide rods need 1e5 unknowns and more"
        )
    if reference.kind != "exact solid":
        reasons.append("section problem: forces do not bend a rod uniformly")
    return reasons


def _bends_only(family: Family) -> bool:
    moments = family.scene.get("moment", [])
    thick = family.length / _radius(family) < 100.0 if moments else False
    return bool(moments) and thick and not any(m["value"][0] or m["value"][1] for m in moments)


def _radius(family: Family) -> float:
    return float(family.scene["rod"][0]["section"]["radius"])


def _about(model: str, kind: str, elements: int, mesh: str) -> dict[str, Any]:
    return {
        "model": model, "kind": kind, "formulation": "", "elements": elements, "mesh": mesh,
        "tangent": "analytic", "predictor": "auto",
    }  # fmt: skip


def _measured(family: Family, reference: Reference, position: Any, seconds: list[float]) -> dict[str, Any]:
    return {
        "status": "converged",
        "position": (np.asarray(position) / family.length).tolist(),
        "error": family.error(position, reference),
        "fastest": min(seconds),
        "median": float(np.median(seconds)),
        "repeats": len(seconds),
        "parts": {"rest": min(seconds)},
    }


def _section(family: Family, reference: Reference) -> CostPoint:
    """The section problem on the coarser of its two meshes; the finer one is the reference."""
    rod, moment = family.scene["rod"][0], family.scene["moment"][0]["value"]

    def solve() -> SectionState:
        mesh, law = section_of(rod["section"], CELLS[0]), law_of(rod["material"])
        if moment[0] or moment[1]:
            return bend_and_twist(mesh, law, np.array(moment))
        return bend(mesh, law, moment=moment[2])

    states, seconds = timed(solve, 1)
    state = states[-1]
    about = _about("section problem", "section", CELLS[0], f"{CELLS[0]} cells across")
    position = state.pose(family.length).centre
    measured = _measured(family, reference, position, seconds)
    return CostPoint(**about, **measured, unknowns=state.point.u.size, iterations=state.iterations)


def _rod(family: Family, reference: Reference) -> CostPoint:
    """The integrated rod; its error is its own estimate, for it is the reference."""
    properties, loads = reference_rod(ancf.scene_from_dict(changed(family.scene, {"elements": 1})))
    try:
        answers, seconds = timed(lambda: solve_rod(properties, loads), 1)
    except RodNotSolved as error:
        return CostPoint(**_about("rod", "rod", 0, ""), status=str(error))
    found = answers[-1]
    about = _about("rod", "rod", found.elements, f"{found.elements} elements of order 8")
    measured = _measured(family, reference, found.position[0], seconds)
    measured["error"] = max(found.estimated_error, float(np.finfo(float).eps))
    return CostPoint(**about, **measured, iterations=found.iterations, steps=found.load_steps)


def _solid(family: Family, reference: Reference, cells: int, slices: int) -> CostPoint:
    """The solid in hex27 from the bent rod, as `reference.solid.solid_pure_bending`, for any law."""
    rod = family.scene["rod"][0]
    moment = np.array(family.scene["moment"][0]["value"], float)
    law = law_of(rod["material"])
    curvature = moment[2] / stiffness_of(changed(family.scene, {"elements": 1})).EI

    def solve() -> SolidResult:
        mesh = rod_mesh(section_of(rod["section"], cells), family.length, slices)
        guess = bent_rod(mesh, curvature, law.poisson_ratio)
        problem = SolidProblem(
            mesh, law, soft_clamp(mesh), guess, moment=moment, formulation=formulation_for(law)
        )
        return solve_solid(problem)

    about = _about("solid hex27", "solid", slices, f"{cells} cells across, {slices} slices")
    results, seconds = timed(solve, 1)
    result = results[-1]
    if not result.converged:
        return CostPoint(**about, status=f"{result.status}: {result.reason}")
    tip = result.tip_position if result.tip_centre is None else result.tip_centre
    return CostPoint(
        **about, **_measured(family, reference, tip, seconds),
        unknowns=result.unknowns, iterations=result.iterations,
    )  # fmt: skip
