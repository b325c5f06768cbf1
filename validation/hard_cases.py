"""Run the hard cases: how each ended, what was measured on it, and what that is worth.

Not solving is right where no equilibrium exists; ending without a typed reason, or with a number that is not
finite, is not. The verdict depends on statuses, deviations and orders, never on time.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache

import ancf
from ancf.errors import InputError
from ancf.newton import Iteration
from ancf.solution import Solution
from validation import hard_drift, hard_measures, hard_threads, hard_walk
from validation.criteria import Finding, Limit, Verdict, judge, worst
from validation.hard_buckling import buckling
from validation.hard_case import HardCase
from validation.hard_drift import drift, shape_of
from validation.hard_ending import ending_fault, solution_fault, solve_case
from validation.hard_families import shapes
from validation.hard_limits import EPS, WALKED, hard_limits
from validation.hard_loads import loads
from validation.hard_pieces import pieces
from validation.hard_ring import loop, ring
from validation.hard_stability import stability
from validation.hard_starts import starts

VARIANTS = {
    "units": hard_drift.in_millimetres,
    "turned": hard_drift.turned,
    "moved": hard_drift.moved,
    "reversed": hard_drift.reversed_rods,
    "renumbered": hard_drift.renumbered,
}


@dataclass(frozen=True)
class HardResult:
    """How a hard case ended and what was measured on it.

    `fault` says why it fails whatever its numbers are; `measured` holds numbers by the names of
    `hard_limits.MEASURES`, None where a number was asked and there is none; `notes` say more on some of them.
    """

    case: HardCase
    verdict: Verdict
    status: str
    reason: str
    fault: str = ""
    steps: int = 0
    cutbacks: int = 0
    iterations: int = 0
    residual: float | None = None
    floor: float | None = None
    measured: dict[str, float | None] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    history: list[Iteration] = field(default_factory=list)
    seconds: float = 0.0
    warnings: list[str] = field(default_factory=list)


@cache
def hard_cases() -> tuple[HardCase, ...]:
    """All of them, in the order of the table; names are unique."""
    cases = (*shapes(), *pieces(), *loads(), *starts(), *buckling(), *stability(), *ring(), *loop())
    names = [case.name for case in cases]
    if len(set(names)) != len(names):
        raise ValueError(f"two hard cases of one name: {sorted(n for n in names if names.count(n) > 1)[0]}")
    return cases


def run_hard_case(case: HardCase, full: bool = False) -> HardResult:
    """Solve one, measure it, and judge both; an exception of the solver is a fault, never a crash."""
    started = time.perf_counter()
    try:
        solution = solve_case(case, case.scene)
    except InputError as error:
        reason = str(error.message.what)
        fault = ending_fault(case, "refused", str(error))
        return HardResult(case, _verdict(fault, []), "refused", reason, fault, seconds=_since(started))
    except Exception as error:  # a traceback is the one thing that must not happen
        reason = f"{type(error).__name__}: {error}"
        return HardResult(case, Verdict.FAIL, "exception", reason, reason, seconds=_since(started))
    seconds = _since(started)
    fault = solution_fault(case, solution)
    measured: dict[str, float | None] = {}
    notes: dict[str, str] = {}
    if case.solvable and solution.status is ancf.Status.CONVERGED:
        try:
            measured, notes = measure(case, solution, full)
        except Exception as error:  # the answer stands; what cannot be measured on it fails
            fault = fault or f"not measured: {type(error).__name__}: {error}"
    findings = judged(hard_limits(case, full), measured)
    return HardResult(
        case,
        _verdict(fault, findings),
        str(solution.status),
        solution.reason,
        fault,
        solution.steps,
        solution.cutbacks,
        solution.iterations,
        _finite(solution.residual),
        _finite(solution.residual_floor),
        measured,
        notes,
        findings,
        list(solution.history),
        seconds,
        list(solution.warnings),
    )


def measure(case: HardCase, solution: Solution, full: bool) -> tuple[dict[str, float | None], dict[str, str]]:
    """Numbers of a converged case by name, and notes on them; NaN where an asked number has no answer."""
    found: dict[str, float] = {"iterations": float(solution.iterations)}
    notes: dict[str, str] = {}
    if case.deviation is not None:
        found["deviation"] = case.deviation(solution)
    found["residual over floor"] = solution.residual / max(
        solution.scene.solver.tolerance, solution.residual_floor
    )
    orders = hard_measures.observed_orders(solution)
    for name, order in zip(("Newton order", "Newton order by steps"), orders, strict=True):
        found[f"{name} below 2"] = 0.0 if order is None else max(0.0, 2.0 - order)
        if order is not None:
            found[name] = order
    found["condition number"] = hard_measures.condition_number(hard_measures.dimensionless_tangent(solution))
    found["min det F"] = hard_measures.smallest_volume_ratio(solution)
    if full or case.drifts == "quick":
        _drifts(case, solution, found, notes, full)
    if full or case.walk == "quick":
        _walk(case, solution, found, notes)
    kept = {name: value for name, value in found.items() if name not in case.not_asked}
    return {name: _finite(value) for name, value in kept.items()}, notes


def _drifts(
    case: HardCase, solution: Solution, found: dict[str, float], notes: dict[str, str], full: bool
) -> None:
    """Drift of every variant; in a full run of one ulp too, and the amplification it is held against."""
    shape, lengths = shape_of(solution), [rod.rod.length for rod in solution.model.rods]

    def against(name: str, variant: hard_drift.Variant) -> float:
        other = solve_case(case, variant.scene)
        if other.status is not ancf.Status.CONVERGED:
            notes[name] = f"{other.status}: {other.reason}"
            return math.nan
        return drift(shape, variant.restore(shape_of(other)), lengths)

    for name, change in VARIANTS.items():
        found[f"drift, {name}"] = against(f"drift, {name}", change(case.scene))
    names = () if case.drifts == "quick" else ((case.name,),)
    one, two = (hard_threads.shapes_with(n, *names).get(case.name) for n in (1, 2))
    found["drift, threads"] = math.nan if one is None or two is None else drift(one, two, lengths)
    if not full:
        return
    changes = {name: against("drift, one ulp", variant) for name, variant in hard_drift.one_ulp(case.scene)}
    by_size = sorted(changes, key=lambda name: (math.isnan(changes[name]), changes[name]))
    found["drift, one ulp"] = changes[by_size[-1]]
    notes.setdefault("drift, one ulp", f"of the {by_size[-1]}")
    amplification = max(1.0, hard_measures.load_amplification(solution))
    found["ulp ratio"] = found["drift, one ulp"] / (EPS * amplification)
    notes["ulp ratio"] = f"amplification {amplification:.2g}"


def _walk(case: HardCase, solution: Solution, found: dict[str, float], notes: dict[str, str]) -> None:
    """A hundred steps: where they lead, and the work on the way."""
    if all(name in case.not_asked for name in WALKED):
        return
    path = hard_walk.walk(case.bounded)
    if len(path) < hard_walk.STEPS:
        notes["drift, hundred steps"] = f"step {len(path) + 1} of {hard_walk.STEPS} did not converge"
        return
    lengths = [rod.rod.length for rod in solution.model.rods]
    found["drift, hundred steps"] = drift(shape_of(solution), shape_of(path[-1]), lengths)
    balance = hard_walk.energy_balance(path)
    found["energy balance"] = balance.error
    order = balance.trapezoid_order
    found["energy order off 2"] = 0.0 if order is None else abs(order - 2.0)
    if order is not None:
        found["energy order"] = order
    kind = "loads have a potential" if solution.model.conservative else "loads without a potential"
    notes["energy balance"] = f"{kind}; trapezoid {balance.trapezoid_error:.1e}"
    if balance.simpson_order is not None:
        notes["energy order off 2"] = f"Simpson: order {balance.simpson_order:.2f}"


def judged(limits: tuple[Limit, ...], measured: dict[str, float | None]) -> list[Finding]:
    """A finding for every limit; a quantity without a number fails."""
    found = []
    for limit in limits:
        value = measured.get(limit.quantity)
        found.append(judge(limit, limit.quantity, math.nan if value is None else value))
    return found


def _verdict(fault: str, findings: list[Finding]) -> Verdict:
    if fault:
        return Verdict.FAIL
    return worst(f.verdict for f in findings) if findings else Verdict.PASS


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _since(started: float) -> float:
    return time.perf_counter() - started


def run(full: bool = False) -> Iterator[HardResult]:
    """Run all, one result at a time."""
    for case in hard_cases():
        yield run_hard_case(case, full)
