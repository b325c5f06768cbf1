"""What a run found, check by check, in a form that can be judged again without running anything."""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from validation.criteria import Finding, Limit, Verdict, judge, worst

if TYPE_CHECKING:
    from validation.expected import Expectation
    from validation.runner import Run

LIMIT = ("value", "unit", "kind", "documented", "spread")
MEASURED = ("observed", "reference_error")
SHOWN = {"value": "limit"}  # names in the certificate where they differ


def evidence_of(run: Run) -> dict[str, dict[str, Any]]:
    """Every required check of a run: findings, how it ended, regimes that the domain is made of, verdict."""
    found: dict[str, dict[str, Any]] = {}
    for case in run.cases:
        if case.case.required:
            name = f"case {case.case.id}"
            found[name] = _entry(case.verdict, case.findings, case.reason)
            found[name]["regimes"] = run.regimes.get(case.case.id, [])
    for study in run.convergence:
        found[f"order {study.study.name} {study.study.element}"] = _entry(study.verdict, study.findings)
    for check in run.reference_checks:
        found[f"reference {check.name}"] = _entry(check.verdict, check.findings)
    for check in run.properties:
        found[f"property {check.name}"] = _entry(check.verdict, [check.finding])
    for hard in run.hard_cases:
        entry = _entry(hard.verdict, hard.findings, hard.fault)
        found[f"hard case {hard.case.name}"] = {**entry, "status": hard.status}
    for name, finding in run.study_findings.items():
        found[name] = _entry(finding.verdict, [finding])
    return found


def verdict_of(name: str, entry: Mapping[str, Any]) -> tuple[Verdict, list[str]]:
    """Verdict of one check judged again from its numbers, and every place where the stated one differs."""
    faults, verdicts = [], []
    for finding in entry["findings"]:
        limit = Limit(finding["quantity"], finding["limit"], finding["unit"], "", finding["kind"],
                      finding["documented"], finding["spread"])  # fmt: skip
        again = judge(
            limit, limit.quantity, _number(finding["observed"]), _number(finding["reference_error"])
        )
        verdicts.append(again.verdict)
        if again.verdict != finding["verdict"]:
            faults.append(
                f"{name}: {finding['quantity']!r} is stated {finding['verdict']}, but {finding['observed']} "
                f"against limit {limit.value:g} is {again.verdict}"
            )
    if "status" in entry and not verdicts:
        verdicts.append(Verdict.PASS)  # its status alone is judged, by `limit_faults`
    found = Verdict.FAIL if entry["reason"] else worst(verdicts)
    if found != entry["verdict"]:
        faults.append(f"{name}: stated {entry['verdict']}, but its numbers say {found}")
    return found, faults


def limit_faults(name: str, entry: Mapping[str, Any], expected: Expectation) -> list[str]:
    """Where the limits of a check differ from those of the present code."""
    faults = []
    quantities = [finding["quantity"] for finding in entry["findings"]]
    for finding in entry["findings"]:
        quantity = finding["quantity"]
        limit = next((k for k in expected.limits if fnmatch.fnmatchcase(quantity, k.quantity)), None)
        if limit is None:
            faults.append(f"{name}: there is no limit for {quantity!r} now")
            continue
        for key in LIMIT:
            then, now = finding[SHOWN.get(key, key)], getattr(limit, key)
            if then != now:
                faults.append(f"{name}: {SHOWN.get(key, key)} of {quantity!r} was {then}, is {now} now")
    for limit in expected.limits:
        if not any(fnmatch.fnmatchcase(quantity, limit.quantity) for quantity in quantities):
            faults.append(f"{name}: no number for {limit.quantity!r}")
    if expected.statuses and entry.get("status") not in expected.statuses:
        faults.append(f"{name}: ended {entry.get('status')!r}, must end in {', '.join(expected.statuses)}")
    return faults


def lists_of(verdicts: Mapping[str, Verdict]) -> dict[str, Any]:
    """Result and verdict lists in the words of in-toto; a documented miss found at its size is passed."""

    def named(*wanted: Verdict) -> list[str]:
        return sorted(name for name, verdict in verdicts.items() if verdict in wanted)

    failed = named(Verdict.FAIL, Verdict.INCONCLUSIVE)
    warned = named(Verdict.WARN)
    return {
        "result": "FAILED" if failed or not verdicts else "WARNED" if warned else "PASSED",
        "passedTests": named(Verdict.PASS, Verdict.KNOWN_LIMIT),
        "warnedTests": warned,
        "failedTests": failed,
    }


def unmeasured(evidence: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The evidence without what differs between two machines that agree."""
    return {
        name: {
            "verdict": entry["verdict"],
            "findings": [
                {key: value for key, value in finding.items() if key not in MEASURED}
                for finding in entry["findings"]
            ],
        }
        for name, entry in evidence.items()
    }


def _entry(verdict: Verdict, findings: Iterable[Finding], reason: str = "") -> dict[str, Any]:
    return {
        "verdict": str(verdict),
        "reason": reason,
        "findings": [
            {
                "quantity": finding.quantity,
                **{SHOWN.get(key, key): getattr(finding.limit, key) for key in LIMIT},
                "observed": finding.observed,
                "reference_error": finding.reference_error
                if math.isfinite(finding.reference_error)
                else None,
                "verdict": str(finding.verdict),
            }
            for finding in findings
        ],
    }


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)
