"""The families as one JSON object and as tables for people. Every number of the object is finite.

Lengths are by the length of the rod, times are CPU seconds; what is not known is null.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from validation.cost.advice import TARGETS, cheapest, sentence
from validation.cost.heading import heading, print_machine
from validation.cost.points import CostPoint, milliseconds, point_dict
from validation.cost.run import FamilyCost
from validation.cost.scaling import ScalePoint, TangentRatio

if TYPE_CHECKING:
    from rich.console import Console


def families_dict(
    costs: Sequence[FamilyCost],
    ratios: Sequence[TangentRatio],
    scaling: Sequence[ScalePoint],
) -> dict[str, Any]:
    """The JSON object of all families."""
    return heading("families", TARGETS) | {
        "families": [family_dict(cost) for cost in costs],
        "tangent_ratio": [ratio_dict(ratio) for ratio in ratios],
        "scaling": [asdict(point) for point in scaling],
    }


def ratio_dict(ratio: TangentRatio) -> dict[str, Any]:
    """Times of the two tangents and their ratios."""
    names = ("assembly_ratio", "paper_ratio", "solve_ratio")
    return asdict(ratio) | {name: getattr(ratio, name) for name in names}


def family_dict(cost: FamilyCost) -> dict[str, Any]:
    """All that was measured of one family."""
    return {
        "name": cost.name,
        "problem": cost.problem,
        "reference": {
            "name": cost.reference,
            "kind": cost.reference_kind,
            "source": cost.reference_source,
            "error": cost.reference_error,
            "position": cost.reference_position,
            "thickness": cost.thickness,
        },
        "points": [point_dict(point) for point in cost.points],
        "floors": [asdict(floor) for floor in cost.floors],
        "omissions": cost.omissions,
        "cheapest": [
            {
                "target": found.target,
                "beam": None if found.beam is None else _short(found.beam),
                "peer": None if found.peer is None else _short(found.peer),
                "solid": None if found.solid is None else _short(found.solid),
            }
            for found in cheapest(cost)
        ],
        "recommendation": sentence(cost),
        "seconds": cost.seconds,
    }


def _short(point: CostPoint) -> dict[str, Any]:
    return {
        "model": point.model, "formulation": point.formulation, "elements": point.elements,
        "mesh": point.mesh, "tangent": point.tangent, "predictor": point.predictor,
        "error": point.error, "seconds": point.median,
    }  # fmt: skip


def print_families(costs: Sequence[FamilyCost], found: dict[str, Any], console: Console) -> None:
    """Tables for people: by family its points, floors, omissions, recommendation."""
    from rich.table import Table

    print_machine(found, console)
    for cost in costs:
        table = Table(
            "model", "mesh", "unknowns", "iterations", "tip error / L", "of the mesh", "fastest", "median",
            "set-up", "kinematics", "assembly", "effects", "linear solve", "rest",
            title=f"{cost.name}: {cost.problem}", title_justify="left",
        )  # fmt: skip
        for p in cost.points:
            if p.converged:
                shares = (
                    p.parts.get(k)
                    for k in ("setup", "kinematics", "assembly", "effects", "linear_solve", "rest")
                )
                table.add_row(
                    p.label, p.mesh, str(p.unknowns), str(p.iterations or ""), _number(p.error),
                    _number(p.discretisation), milliseconds(p.fastest), milliseconds(p.median),
                    *("" if s is None else milliseconds(s) for s in shares),
                )  # fmt: skip
        console.print(table)
        console.print(
            f"  reference: {cost.reference} ({cost.reference_kind}), own error {cost.reference_error:.1e} L;"
            f" {cost.reference_source}"
        )
        if cost.thickness is not None:
            console.print(f"  the infinitely thin rod is {cost.thickness:.1e} L away")
        for floor in cost.floors:
            console.print(
                f"  {floor.model} {floor.formulation}: no mesh removes {floor.error:.1e} ± {floor.bar:.0e} L"
            )
        for omission in cost.omissions:
            console.print(f"  omitted: {omission}")
        console.print(f"  {sentence(cost)}\n")
    for r in found["tangent_ratio"]:
        console.print(
            f"{r['element']}, {r['elements']} elements: the analytic tangent is {r['paper_ratio']:.0f} times"
            f" faster than the paper's differences by coordinate, {r['assembly_ratio']:.0f} times faster than"
            f" differences of all elements at once; whole solve: {r['solve_ratio']:.1f} times"
        )
    for s in found["scaling"]:
        console.print(
            f"{s['element']}, {s['elements']} elements: {milliseconds(s['seconds'])};"
            f" an element: {1e6 * s['seconds'] / s['elements']:.0f} us,"
            f" {s['memory'] / s['elements'] / 1e3:.0f} kB"
        )


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.1e}"
