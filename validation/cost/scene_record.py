"""The cost of one scene as a JSON object and as a table for people. Every number of the object is finite."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from validation.cost.heading import heading, print_machine
from validation.cost.ladder import TARGETS, ElementLadder, SceneCost
from validation.cost.points import CostPoint, milliseconds, point_dict

if TYPE_CHECKING:
    from rich.console import Console


def scene_dict(cost: SceneCost) -> dict[str, Any]:
    """The JSON object of one scene."""
    needs = []
    for target in TARGETS:
        best = cost.best(target)
        entry: dict[str, Any] = {"target": target, "reached": best is not None}
        if best is not None:
            entry |= _need(*best)
        entry["by_element"] = [
            _need(ladder, point) for ladder in cost.ladders if (point := ladder.need(target)) is not None
        ]
        needs.append(entry)
    return heading("scene", TARGETS) | {
        "title": cost.title,
        "rods": cost.rods,
        "needs": needs,
        "ladders": [_ladder(ladder) for ladder in cost.ladders],
        "omissions": cost.omissions,
        "warnings": cost.warnings,
        "recommendation": advice(cost),
    }


def advice(cost: SceneCost) -> str:
    """What to take for the finest target that the ladder reaches, in one sentence."""
    for target in reversed(TARGETS):
        best = cost.best(target)
        if best is not None:
            ladder, point = best
            text = f"For {_percent(target)} of the length take {ladder.element}, {ladder.formulation}, with "
            text += f"{point.mesh} ({milliseconds(point.median)})."
            finer = [t for t in TARGETS if t < target]
            if finer:
                text += f" {' and '.join(_percent(t) for t in finer)} were not reached on this ladder."
            return text
    return (
        "The ladder does not even show 1 % to be reached."
        if cost.converged
        else "No mesh has an equilibrium."
    )


def _need(ladder: ElementLadder, point: CostPoint) -> dict[str, Any]:
    return {
        "element": ladder.element, "formulation": ladder.formulation, "elements": point.elements,
        "error": point.error, "seconds": point.median, "iterations": point.iterations,
        "unknowns": point.unknowns, "distance": ladder.distance,
    }  # fmt: skip


def _ladder(ladder: ElementLadder) -> dict[str, Any]:
    limit = ladder.limit
    return {
        "element": ladder.element,
        "formulation": ladder.formulation,
        "limit": None if limit is None else limit.value.tolist(),
        "error_bar": None if limit is None else limit.bar,
        "order": None if limit is None else limit.order,
        "distance": ladder.distance,
        "points": [point_dict(point) for point in ladder.points],
    }


def print_scene(cost: SceneCost, found: dict[str, Any], console: Console) -> None:
    """The table: what each element needs for each target."""
    from rich.table import Table

    print_machine(found, console)
    heads = [f"for {_percent(t)}" for t in TARGETS]
    table = Table(
        "element", *heads, "error bar of its limit", "order", "limit differs by", title=cost.title or None
    )
    for ladder in cost.ladders:
        needs = [ladder.need(target) for target in TARGETS]
        limit = ladder.limit
        table.add_row(
            f"{ladder.element}, {ladder.formulation}",
            *("not reached" if p is None else f"{p.mesh}, {milliseconds(p.median)}" for p in needs),
            "no limit" if limit is None else f"{limit.bar:.1e} L",
            "" if limit is None or limit.order is None else f"{limit.order:.1f}",
            "" if ladder.distance is None else f"{ladder.distance:.1e} L",
        )
    console.print(table)
    console.print(
        "Discretisation error of the tip by the length, against the limit of each element's own ladder;"
        " what an element cannot show on any mesh is not in it."
    )
    for omission in cost.omissions:
        console.print(f"  omitted: {omission}")
    for warning in cost.warnings:
        console.print(f"  warning: {warning}")
    console.print(found["recommendation"])


def _percent(target: float) -> str:
    return f"{100.0 * target:g} %"
