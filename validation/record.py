"""`report.json`: the run as plain data, every number finite, written whole or not at all."""

from __future__ import annotations

import json
import math
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.criteria import Finding, Verdict

if TYPE_CHECKING:
    from ancf.newton import Iteration
    from validation.problems import CaseResult
    from validation.runner import Run
from validation.cases import formulation_of

SCHEMA = 1


def as_dict(run: Run) -> dict[str, Any]:
    """The run in the schema of `report.json`."""
    from validation.cost.record import family_dict, ratio_dict  # scikit-fem

    verdict, reasons = run.verdict
    # Nobody should take a selection for the whole.
    shown = "PARTIAL" if verdict is Verdict.PASS and not run.complete else str(verdict)
    verdicts = [r.verdict for r in run.cases]
    return _finite(
        {
            "schema": SCHEMA,
            "verdict": shown,
            "complete": run.complete,
            "scope": run.scope,
            "reasons": reasons,
            "blocking": run.blocking,
            "certificate": run.certificate,
            "certificate_reasons": run.certificate_reasons,
            "notices": run.notices,
            "started": run.started,
            "counts": {str(v): verdicts.count(v) for v in Verdict},
            "cases": [case_dict(result) for result in run.cases],
            "convergence": [
                {
                    "name": r.study.name,
                    "element": r.study.element,
                    "meshes": list(r.study.meshes),
                    "errors": r.errors,
                    "order": r.slope,
                    "promised": r.study.promised,
                    "verdict": str(r.verdict),
                    "checks": [finding_dict(f) for f in r.findings],
                }
                for r in run.convergence
            ],
            "reference_checks": [
                {
                    "name": r.name,
                    "truth": r.truth,
                    "sizes": r.sizes,
                    "errors": r.errors,
                    "orders": r.orders,
                    "promised": r.promised,
                    "note": r.note,
                    "verdict": str(r.verdict),
                    "checks": [finding_dict(f) for f in r.findings],
                }
                for r in run.reference_checks
            ],
            "properties": [
                {
                    "name": r.name,
                    "title": r.title,
                    "examples": r.examples,
                    "seed": list(r.worst_seed),
                    "observed": r.finding.observed,
                    "limit": r.bound,
                    "unit": r.unit,
                    "verdict": str(r.verdict),
                }
                for r in run.properties
            ],
            "hard_cases": [
                {
                    "name": r.case.name,
                    "family": r.case.family,
                    "expected": r.case.expected,
                    "status": r.status,
                    "reason": r.reason,
                    "fault": r.fault,
                    "steps": r.steps,
                    "cutbacks": r.cutbacks,
                    "iterations": r.iterations,
                    "residual": r.residual,
                    "residual_floor": r.floor,
                    "measured": r.measured,
                    "notes": r.notes,
                    "checks": [finding_dict(f) for f in r.findings],
                    "history": [_iteration(h) for h in r.history],
                    "seconds": r.seconds,
                    "verdict": str(r.verdict),
                }
                for r in run.hard_cases
            ],
            "studies": {name: finding_dict(f) for name, f in run.study_findings.items()},
            "locking": [vars(point) for point in run.locking],
            "remedies": [vars(remedy) for remedy in run.remedies],
            "work_precision": [family_dict(cost) for cost in run.work],
            "tangent_ratio": [ratio_dict(ratio) for ratio in run.tangents],
            "scaling": [vars(point) for point in run.scaling],
            "effect_calls": [vars(row) for row in run.effect_calls],
            "effect_costs": [{**vars(cost), "ratio": cost.ratio} for cost in run.effect_costs],
            "failed_parts": run.failed_parts,
            "environment": run.environment,
            "versions": run.versions,
            "seconds": run.seconds,
        }
    )


def _iteration(entry: Iteration) -> list[float]:
    """Load factor, number in its run, residual, step of an iteration, to the digits that a reader wants."""
    return [entry.load_factor, entry.iteration, float(f"{entry.residual:.3e}"), float(f"{entry.step:.3e}")]


def case_dict(result: CaseResult) -> dict[str, Any]:
    """One case of `report.json`."""
    case = result.case
    rod = case.rod if case.scene else {}
    return {
        "id": case.id,
        "row": case.row,
        "title": case.title,
        "required": case.required,
        "problem": case.problem,
        "loads": case.loads,
        "element": rod.get("element", "3333"),
        "formulation": formulation_of(rod),
        "reference": {
            "name": case.reference.name,
            "independence": case.reference.independence,
            "source": case.reference.source,
            "estimated_error": case.reference.estimated_error,
        },
        "verdict": str(result.verdict),
        "reason": result.reason,
        "checks": [finding_dict(finding) for finding in result.findings],
        "warnings": result.warnings,
        "reproduce": case.reproduce,
        "seconds": result.seconds,
    }


def finding_dict(finding: Finding) -> dict[str, Any]:
    """One check of `report.json`."""
    limit = finding.limit
    return {
        "quantity": finding.quantity,
        "observed": finding.observed,
        "limit": limit.value,
        "unit": limit.unit,
        "margin": finding.margin,
        "verdict": str(finding.verdict),
        "kind": limit.kind,
        "reason": limit.reason,
        "documented": limit.documented,
        "reference_error": finding.reference_error,
        "note": finding.note,
    }


def _finite(value: Any) -> Any:
    """Plain Python with every number that is not finite replaced by None."""
    if isinstance(value, dict):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, bool | int | str) or value is None:
        return value
    number = float(value)
    return number if math.isfinite(number) else None


def write_json(run: Run, folder: Path) -> Path:
    """Write `report.json` into a folder that exists; atomic."""
    return write_text(folder / "report.json", json.dumps(as_dict(run), indent=1, allow_nan=False) + "\n")


def write_text(target: Path, text: str) -> Path:
    """Write a file through a temporary one beside it, so that an interrupted run leaves no half of it."""
    handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(temporary, 0o644)
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise
    return target
