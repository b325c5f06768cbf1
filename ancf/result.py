"""The result of a solve as the JSON file holds it; every number is finite."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ancf.arclength import PathPoint
    from ancf.model import Model
    from ancf.solution import Solution


def result_of(solution: Solution) -> dict[str, Any]:
    """The result of a solve in plain Python."""
    import ancf

    rods = {}
    for rod in solution.model.rods:
        name = rod.rod.name
        tip = solution.tip(name)
        force, moment = solution.reaction(name)
        rods[name] = {
            "tip": {
                "position": tip.position.tolist(),
                "r_x": tip.r_x.tolist(),
                "r_y": tip.r_y.tolist(),
                "r_z": tip.r_z.tolist(),
                "rotation": tip.rotation.tolist(),
            },
            "nodes": solution.nodes(name).tolist(),
            "strain_energy": solution.strain_energy(name),
            "reaction": {"force": force.tolist(), "moment": moment.tolist()},
        }
    result = {
        "schema": 1,
        "title": solution.scene.title,
        "status": str(solution.status),
        "reason": solution.reason,
        "rods": rods,
        "steps": solution.steps,
        "cutbacks": solution.cutbacks,
        "iterations": solution.iterations,
        "residual": solution.residual,
        "residual_floor": solution.residual_floor,
        "load_factor": solution.load_factor,
        "effects": solution.effects,
        "reductions": solution.reductions,
        "seconds": solution.seconds,
        "error_estimate": None if solution.accuracy is None else solution.accuracy.estimate,
        "unknowns": solution.unknowns,
        "warnings": solution.warnings,
        "balance": solution.balance().as_dict(),
        "versions": {"ancf": ancf.__version__, "numpy": np.__version__},
    }
    if solution.accuracy is not None:
        result["accuracy"] = solution.accuracy.as_dict()
    if solution.scene.tendons:
        result["tendons"] = [tendon.as_dict() for tendon in solution.tendons]
    if solution.scene.springs or solution.scene.foundations or solution.scene.contacts:
        from ancf.passive_reports import passive_reports

        result |= passive_reports(solution.model, solution.q)
    if solution.scene.joints:
        result["joints"] = [carried.as_dict() for carried in solution.joints]
    if solution.stability is not None:
        result["stability"] = solution.stability.as_dict()
    if solution.path:
        result["path"] = [_path_entry(solution.model, point) for point in solution.path]
    return result


def _path_entry(model: Model, point: PathPoint) -> dict[str, Any]:
    tips = {rod.rod.name: rod.nodal(point.q)[-1, 0] + rod.rod.base.position for rod in model.rods}
    return {
        "arc": float(point.arc),
        "load_factor": float(point.load_factor),
        "negative_pivots": point.negative,
        "tip": {name: tip.tolist() for name, tip in tips.items()},
    }
