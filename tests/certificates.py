"""A run in which everything passed, copies of the packages it speaks about, and their verification."""

from __future__ import annotations

import shutil

from tests.regimes import REGIME
from validation import convergence, digests
from validation.cases import load_cases
from validation.certificate import verify
from validation.cost.points import CostPoint
from validation.cost.run import FamilyCost
from validation.cost.scaling import ScalePoint, TangentRatio
from validation.criteria import Verdict, judge, worst
from validation.digests import Roots
from validation.effect_costs import EffectCost, SceneCalls
from validation.expected import expected_checks
from validation.hard_cases import HardResult, hard_cases
from validation.hard_limits import hard_limits
from validation.locking import LockingPoint, SlendernessRow
from validation.locking_remedies import Remedy
from validation.outcome import Outcome
from validation.problems import CaseResult
from validation.properties import PROPERTIES
from validation.property_runs import PropertyResult
from validation.reference_checks import CheckResult
from validation.runner import Run

# The copies of these tests have to earn their certificate.
LEFT_OUT = shutil.ignore_patterns("__pycache__", "certificate.json")
CASE, CASE_FILE = "HX-3333-24", "05_helix.toml"


def findings(limits, error=0.0):
    """Numbers that meet their limits ten times over, or miss them by what is documented."""
    return [
        judge(
            limit,
            limit.quantity.replace("[[]", "[").replace("*", "any"),
            limit.documented or limit.value / 10,
            error,
        )
        for limit in limits
    ]


def passing_run(roots):
    """A full run in which everything passed, without the twenty minutes."""
    cases = load_cases(roots.cases)
    expected = expected_checks(cases)
    run = Run("full", "2026-01-01 00:00 UTC", expected=cases, seconds={"total": 1.0})
    for case in cases:
        held = findings(case.limits)
        run.cases.append(CaseResult(case, worst(f.verdict for f in held), held, Outcome({}, []), 0.1))
    for study in convergence.studies(True):
        limits = expected[f"order {study.name} {study.element}"].limits
        run.convergence.append(convergence.StudyResult(study, [1.0], study.promised, findings(limits)))
    for name, expectation in expected.items():
        if name.startswith("reference "):
            run.reference_checks.append(
                CheckResult(name.removeprefix("reference "), "", (1.0,), {}, {}, findings(expectation.limits))
            )
    for check in PROPERTIES:
        (held,) = findings(expected[f"property {check.name}"].limits)
        run.properties.append(
            PropertyResult(check.name, check.title, check.bound, check.unit, 3, held, (1, 2, 3), 0.1)
        )
    for case in hard_cases():
        held = findings(hard_limits(case))
        run.hard_cases.append(HardResult(case, Verdict.PASS, case.expected[0], "", findings=held))
    run.locking.append(LockingPoint("3333", "enhanced", 0.3, 1.0, 1.0))
    run.slenderness.append(SlendernessRow(20, 1, [0.1], [0.1]))
    run.remedies.append(Remedy("3343", "2 points", True, 0, [1e-6] * 4, [1e-6] * 3))
    point = CostPoint("3333", "beam", "enhanced", 8, "8", "analytic", "auto", "converged", error=1e-4)
    run.work.append(FamilyCost("pure bending", "", "", "", "", 1e-9, [], None, [point]))
    run.tangents.append(TangentRatio("3333", 12, 1.0, 20.0, 100.0, 1.0, 5.0))
    run.scaling.append(ScalePoint("3243", 100, 1200, 1.0, 1, 4, "converged"))
    run.effect_calls.append(SceneCalls("arm", "converged", 4, {"elastic": 5}, {"elastic": 1.0}))
    run.effect_costs.append(EffectCost("force", 12, 0.1, 1.0))
    run.regimes = {case.id: [REGIME] for case in cases if case.id in (CASE, "HX-3333-12")}
    run.subject = digests.of_solver(roots)
    run.configuration = digests.of_judges(roots) | {
        f"case {case.id}": digests.of_case(case) for case in cases if case.required
    }
    return run


def roots_in(folder):
    return Roots(*(folder / name for name in ("ancf", "reference", "validation")))


def reasons(tree, file=None):
    found = verify(file or tree / "certificate.json", roots_in(tree))
    assert found.valid is (not found.reasons)
    return found.reasons


def edit(path, old, new, count=1):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, count))
