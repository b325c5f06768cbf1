"""How a hard case ends: solved within its budget, and what makes an ending wrong whatever was measured."""

from __future__ import annotations

import re

import numpy as np

import ancf
from ancf.solution import Solution
from ancf.solver import prepare
from validation.hard_case import HardCase
from validation.hard_drift import Scene
from validation.hard_measures import smallest_volume_ratio


def solve_case(case: HardCase, scene: Scene) -> Solution:
    """Solve the scene of a case, or another that describes the same rod, within the budget of the case."""
    options = {"max_seconds": case.budget, **scene.get("solver", {})}
    record = ancf.scene_from_dict({**scene, "solver": options})
    return ancf.solve(record, start=None if case.start is None else case.start(prepare(record)))


def solution_fault(case: HardCase, solution: Solution) -> str:
    """Why an answer is wrong whatever its numbers are; "" if it is not."""
    if not np.isfinite(solution.q).all():
        return "the state is not finite"
    status, converged = str(solution.status), solution.status is ancf.Status.CONVERGED
    said = " ".join([solution.reason, *solution.warnings])
    if not converged and not solution.reason:
        return f"{status} without a reason"
    fault = ending_fault(case, status, said)
    if fault or not converged:
        return fault
    if solution.stable is False:
        if case.stable:
            return "converged to an unstable equilibrium"
        if "unstable" not in said:
            return "an unstable equilibrium without a warning"
    if not smallest_volume_ratio(solution) > 0.0:
        return "converged with an element turned inside out"
    return ""


def ending_fault(case: HardCase, status: str, said: str) -> str:
    """Why a case must not end in a status, or with these words; "" if it may."""
    if status not in case.expected:
        return f"ended {status}, must end in {' or '.join(case.expected)}"
    if not re.search(case.said, said):
        return f"its reason or warning does not say {case.said!r}: {said!r}"
    return ""
