"""Cost of finding the equilibrium: iterations and load steps. Our own earlier numbers, kept "
"apart from references."""

from __future__ import annotations

from typing import Any

from validation.cases import Case
from validation.outcome import Outcome, Row
from validation.scenes import changed, in_si, solve, stiffness_of


def iterations(case: Case) -> Outcome:
    """Linear solves and load steps of scenes that differ in slenderness (`slenderness` in the "
    "parameters, L/R)."""
    observed: dict[str, float] = {}
    rows: list[Row] = []
    solution = scene = None
    for ratio in case.parameters["slenderness"]:
        scene = in_si(changed(case.scene, {"section": _section(case, ratio)}))
        solution = solve(scene)
        label = f"L/R = {ratio:g}"
        observed[f"iterations, {label}"] = float(solution.iterations)
        rows.append(Row(f"iterations, {label}", float(solution.iterations), None, ""))
        if case.parameters.get("one_step", True):
            observed[f"load steps, {label}"] = float(solution.steps + solution.cutbacks)
            rows.append(Row(f"load steps, {label}", float(solution.steps), 1.0, ""))
    return Outcome(observed, rows, solution, scene)


def _section(case: Case, ratio: float) -> dict[str, Any]:
    return {"shape": "circle", "radius": stiffness_of(case.scene).length / ratio}
