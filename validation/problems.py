"""Problems by name: what a case file may ask for, and how one case is run and judged."""

from __future__ import annotations

import fnmatch
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from validation import (
    problems_accuracy,
    problems_actuated,
    problems_cross,
    problems_force,
    problems_identity,
    problems_moment,
    problems_motion,
    problems_newton,
    problems_passive,
    problems_stress,
    problems_together,
)
from validation.cases import Case
from validation.criteria import Finding, Limit, Verdict, judge, worst
from validation.outcome import Outcome

PROBLEMS: dict[str, Callable[[Case], Outcome]] = {
    "helix": problems_moment.helix,
    "pure bending": problems_moment.pure_bending,
    "bending stiffness": problems_moment.bending_stiffness,
    "torsion stiffness": problems_moment.torsion_stiffness,
    "vorticity angle": problems_moment.vorticity_angle,
    "elastica": problems_force.elastica,
    "rod": problems_force.rod,
    "published deflection": problems_force.published_deflection,
    "uniaxial": problems_force.uniaxial,
    "rubber stretch": problems_force.rubber_stretch,
    "rigid motion": problems_identity.rigid_motion,
    "patch": problems_identity.patch,
    "moment identities": problems_identity.moment_identities,
    "far base": problems_identity.far_base,
    "zero modes": problems_identity.zero_modes,
    "iterations": problems_newton.iterations,
    "cross-check": problems_cross.cross_check,
    "gap rate": problems_cross.gap_rate,
    "ladder": problems_cross.ladder,
    "section stress": problems_stress.section_stress,
    "estimated error": problems_accuracy.estimated_error,
    "model error": problems_accuracy.model_error,
    "actuated": problems_actuated.actuated,
    "actuated rod": problems_together.actuated_rod,
    "closed tube": problems_actuated.closed_tube,
    "passive": problems_passive.passive,
    "moved": problems_motion.moved,
}


@dataclass(frozen=True)
class CaseResult:
    """One case after its run: findings, the worst verdict, what was found, and seconds."""

    case: Case
    verdict: Verdict
    findings: list[Finding]
    outcome: Outcome | None
    seconds: float
    reason: str = ""
    warnings: list[str] = field(default_factory=list)


def run_case(case: Case) -> CaseResult:
    """Run one case and judge it; whatever goes wrong is a FAIL with its reason, so that the others run."""
    started = time.perf_counter()
    try:
        outcome = PROBLEMS[case.problem](case)
        warnings = [] if outcome.solution is None else list(outcome.solution.warnings)
    except Exception as error:  # a crash is a finding about this case, not the end of the report
        reason = f"{type(error).__name__}: {error}"
        return CaseResult(case, Verdict.FAIL, [], None, time.perf_counter() - started, reason)
    findings = hold(case, outcome)
    verdicts = [finding.verdict for finding in findings]
    reason = "" if findings else "nothing was compared"
    if case.warning and not any(case.warning in text for text in warnings):
        reason = f"the solver does not warn here: {case.warning!r} is in none of its warnings"
        verdicts.append(Verdict.FAIL)
    unheld = sorted({f.quantity for f in findings if f.note == NO_LIMIT})
    unused = [limit.quantity for limit in case.limits if not _matches(limit, outcome)]
    if unheld or unused:
        reason = f"limits and quantities do not match: {', '.join(unheld + unused)}"
        verdicts.append(Verdict.FAIL)
    seconds = time.perf_counter() - started
    return CaseResult(case, worst(verdicts), findings, outcome, seconds, reason, warnings)


NO_LIMIT = "no limit for this quantity"


def hold(case: Case, outcome: Outcome) -> list[Finding]:
    """Each quantity against its limit: the first whose name or pattern fits."""
    findings = []
    for quantity, observed in outcome.observed.items():
        limit = next((k for k in case.limits if fnmatch.fnmatchcase(quantity, k.quantity)), None)
        if limit is None:
            nothing = Limit(quantity, 1e-300, "", NO_LIMIT)
            findings.append(Finding(quantity, nothing, observed, 0.0, Verdict.FAIL, None, NO_LIMIT))
            continue
        error = outcome.reference_error.get(quantity, case.reference.estimated_error)
        findings.append(judge(limit, quantity, observed, error))
    return findings


def _matches(limit: Limit, outcome: Outcome) -> bool:
    return any(fnmatch.fnmatchcase(quantity, limit.quantity) for quantity in outcome.observed)
