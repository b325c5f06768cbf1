"""Run the validation: cases, orders, properties, hard cases, studies; one record, one verdict."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation import convergence, digests, hard_cases, locking, locking_remedies, property_runs
from validation.cases import CASES, Case, load_cases
from validation.convergence import Study, StudyResult
from validation.cost import run as cost, scaling
from validation.cost.families import Family
from validation.cost.run import FamilyCost
from validation.cost.scaling import ScalePoint, TangentRatio
from validation.criteria import Limit, Verdict, judge, largest, overall
from validation.digests import Roots
from validation.effect_costs import EffectCost, SceneCalls, effect_costs, scene_calls
from validation.environment import environment, versions
from validation.hard_cases import HardCase, HardResult
from validation.journal import Journal, revive, run_key
from validation.locking import LockingPoint, SlendernessRow
from validation.locking_remedies import Remedy
from validation.problems import CaseResult, run_case
from validation.property_runs import PropertyResult
from validation.regime import ACCURATE, regimes

if TYPE_CHECKING:
    from validation.reference_checks import CheckResult

Progress = Callable[[str, int, int], None]  # part, done, of how many

# Part -> the list of `Run` that holds its results.
FIELDS = {
    "cases": "cases",
    "convergence": "convergence",
    "reference checks": "reference_checks",
    "properties": "properties",
    "locking": "locking",
    "slenderness": "slenderness",
    "remedies": "remedies",
    "hard cases": "hard_cases",
    "work-precision": "work",
    "tangents": "tangents",
    "scaling": "scaling",
    "effect calls": "effect_calls",
    "effect costs": "effect_costs",
}
PARTS = tuple(FIELDS)
LOCKING = Limit(
    "EI ratio against its closed form", 1e-4, "-", "linear range, constant curvature: exact in one element"
)
SLENDERNESS = Limit(
    "distance from the documented table", 1.0, "2e-4 + 10 %", "two printed digits, another clamp at L/H = 20",
    kind="non-regression",
)  # fmt: skip
REMEDIES = Limit(
    "tip error of 3343 and cable by its bound", 1.0, "5e-4 L (12 elements), 1e-4 L (24)",
    "L/R = 500 and 2000, P L^2/EI = 10 and |M| L/EI = 2.5; infinite with a mode besides rigid motions",
)  # fmt: skip
FLOOR = Limit(
    "error of 3333, finest mesh", 1.2e-3, "L",
    "section behaviour of second order, 6e-4 to 9e-4 L at L/R = 40 and 90 degrees, is outside a "
    "linear section",
)  # fmt: skip
# Checks that are one number of a study, by name.
STUDIES = {
    "locking curve": LOCKING, "slenderness table": SLENDERNESS, "remedies": REMEDIES, "work-precision": FLOOR,
}  # fmt: skip


@dataclass(frozen=True)
class Task:
    """The smallest piece of a run that is kept when the run is interrupted.

    Parameters
    ----------
    part, name : where it belongs
    compute : gives its results
    kind : type of the results
    declared : objects of the code that results refer to, by type; they are not stored
    """

    part: str
    name: str
    compute: Callable[[], list[Any]]
    kind: type
    declared: Mapping[type, Any] = field(default_factory=dict)


@dataclass
class Run:
    """Everything a run found."""

    scope: str
    started: str
    expected: list[Case] = field(default_factory=list)
    cases: list[CaseResult] = field(default_factory=list)
    convergence: list[StudyResult] = field(default_factory=list)
    reference_checks: list[CheckResult] = field(default_factory=list)
    properties: list[PropertyResult] = field(default_factory=list)
    locking: list[LockingPoint] = field(default_factory=list)
    slenderness: list[SlendernessRow] = field(default_factory=list)
    remedies: list[Remedy] = field(default_factory=list)
    hard_cases: list[HardResult] = field(default_factory=list)
    work: list[FamilyCost] = field(default_factory=list)
    tangents: list[TangentRatio] = field(default_factory=list)
    scaling: list[ScalePoint] = field(default_factory=list)
    effect_calls: list[SceneCalls] = field(default_factory=list)
    effect_costs: list[EffectCost] = field(default_factory=list)
    failed_parts: dict[str, str] = field(default_factory=dict)
    parts: tuple[str, ...] = PARTS
    selection: tuple[str, ...] = ()
    regimes: dict[str, list[dict[str, Any]]] = field(default_factory=dict)  # of solved cases, by id
    subject: dict[str, str] = field(default_factory=dict)  # digests of ancf/ when the run began
    configuration: dict[str, str] = field(default_factory=dict)  # of what judges it, cases included
    certificate: str | None = None  # id of the certificate of this run, or of the shipped one if it holds
    certificate_reasons: list[str] = field(default_factory=list)  # why there is none
    notices: list[str] = field(default_factory=list)  # files that were discarded or taken up, by name
    seconds: dict[str, float] = field(default_factory=dict)
    environment: dict[str, str] = field(default_factory=environment)
    versions: dict[str, str] = field(default_factory=versions)

    @property
    def complete(self) -> bool:
        """Whether everything of the scope was asked for, not a selection."""
        return not self.selection and self.parts == PARTS

    @property
    def checks(self) -> dict[str, Verdict]:
        """Every required verdict by name."""
        found = {f"case {r.case.id}": r.verdict for r in self.cases if r.case.required}
        found |= {f"order {r.study.name} {r.study.element}": r.verdict for r in self.convergence}
        found |= {f"reference {r.name}": r.verdict for r in self.reference_checks}
        found |= {f"property {r.name}": r.verdict for r in self.properties}
        found |= {f"hard case {r.case.name}": r.verdict for r in self.hard_cases}
        found |= {name: finding.verdict for name, finding in self.study_findings.items()}
        return found | {f"part {name}": Verdict.FAIL for name in self.failed_parts}

    @property
    def study_findings(self) -> dict:
        """Checks of the studies that are one number each."""
        found = {}
        if self.locking:
            worst = largest(*(abs(p.ratio / p.exact - 1.0) for p in self.locking))
            found["locking curve"] = judge(LOCKING, LOCKING.quantity, worst)
        if self.slenderness:
            worst = largest(*(row.disagreement for row in self.slenderness))
            found["slenderness table"] = judge(SLENDERNESS, SLENDERNESS.quantity, worst)
        if self.remedies:
            worst = largest(*(remedy.excess for remedy in self.remedies if remedy.best))
            found["remedies"] = judge(REMEDIES, REMEDIES.quantity, worst)
        bending = next((c for c in self.work if c.name == "pure bending"), None)
        if bending is not None:
            finest = bending.finest("3333")
            error = math.nan if finest is None or finest.error is None else finest.error
            found["work-precision"] = judge(FLOOR, FLOOR.quantity, error, bending.reference_error)
        return found

    @property
    def skipped(self) -> list[str]:
        """Required cases of the scope that were not run, and whole parts without a result."""
        done = {result.case.id for result in self.cases}
        missing = [case.id for case in self.expected if case.required and case.id not in done]
        empty = [name for name in self.parts if not getattr(self, FIELDS[name])]
        return missing + [f"part {name}" for name in empty if name != "cases"]

    @property
    def verdict(self) -> tuple[Verdict, list[str]]:
        """Verdict of the run and the reasons it is not PASS."""
        ran = len(self.cases) if "cases" in self.parts else max(len(self.checks), 0)
        return overall(self.checks.values(), ran, self.skipped)

    @property
    def blocking(self) -> list[str]:
        """Names of the required checks that failed or were inconclusive."""
        return [name for name, v in self.checks.items() if v in (Verdict.FAIL, Verdict.INCONCLUSIVE)]


def select(cases: Iterable[Case], scope: str, wanted: tuple[str, ...] = ()) -> list[Case]:
    """Cases of a scope: the quick set, or all in a full run; or those named, whatever their set."""
    if wanted:
        return [case for case in cases if case.id in wanted]
    return [case for case in cases if scope == "full" or case.set == "quick"]


def all_cases(folder: Path = CASES) -> list[Case]:
    """Every case of the present code, whatever its scope."""
    return load_cases(folder)


def run(
    scope: str = "quick",
    progress: Progress | None = None,
    wanted: tuple[str, ...] = (),
    parts: tuple[str, ...] = PARTS,
    folder: Path | None = None,
    fresh: bool = False,
) -> Run:
    """Run the validation.

    Parameters
    ----------
    scope : ``quick`` or ``full`` (finer meshes, more examples)
    progress : called with the part, how much of it is done and of how many
    wanted : names of single cases; only they are run, and the run is not complete
    parts : which parts to run
    folder : where the journal of a full run is kept until it is finished; none if None
    fresh : recompute stored references and discard a journal
    """
    from reference.cache import open_session

    record = Run(scope, datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"), parts=parts, selection=wanted)
    if wanted:
        record.parts = parts = ("cases",)
    record.expected = select(all_cases(), scope, wanted) if "cases" in parts else []
    # Taken before anything runs: a file edited meanwhile must not be certified.
    roots = Roots()
    record.subject = digests.of_solver(roots)
    record.configuration = digests.of_judges(roots) | {
        f"case {case.id}": digests.of_case(case) for case in record.expected if case.required
    }
    cache = open_session(fresh)
    journal = None
    if folder is not None and scope == "full" and not wanted:
        key = run_key(record.subject, record.configuration, versions=record.versions, scope=[scope, *parts])
        journal = Journal(folder, key, fresh)
        record.notices += journal.notices
    for part in parts:
        _collect(record, part, progress or (lambda part, done, count: None), journal)
    record.seconds["total"] = sum(record.seconds.values())
    record.notices += cache.warnings
    used = [event.what for event in cache.events]
    record.environment["stored references"] = f"{used.count('hit')} used, {used.count('computed')} computed"
    if journal is not None:
        journal.remove()
    return record


def tasks(part: str, scope: str, expected: Iterable[Case]) -> Iterator[Task]:
    """Tasks of one part, in their order."""
    full = scope == "full"
    if part == "cases":
        for case in expected:
            yield Task(part, case.id, partial(_one_case, case), CaseResult, {Case: case})
    elif part == "convergence":
        for study in convergence.studies(full):
            name = f"{study.name} {study.element}"
            yield Task(part, name, partial(_one_study, study), StudyResult, {Study: study})
    elif part == "reference checks":
        from validation.reference_checks import CheckResult, checks  # scikit-fem

        for check in checks(full):
            yield Task(part, check.name, partial(_one_check, check.run), CheckResult)
    elif part == "properties":
        counts = (100, 20) if full else (20, 5)
        yield Task(part, "all", lambda: list(property_runs.run(*counts)), PropertyResult)
    elif part == "locking":
        yield Task(part, "curve", locking.locking_curve, LockingPoint)
    elif part == "slenderness":
        yield Task(part, "table", locking.slenderness_table, SlendernessRow)
    elif part == "remedies":
        yield Task(part, "table", locking_remedies.remedies, Remedy)
    elif part == "hard cases":
        for case in hard_cases.hard_cases():
            yield Task(part, case.name, partial(_one_hard_case, case, full), HardResult, {HardCase: case})
    elif part == "work-precision":
        for family in cost.families():
            yield Task(part, family.name, partial(_one_family, family, full), FamilyCost)
    elif part == "tangents":
        yield Task(part, "all", scaling.tangent_ratios, TangentRatio)
    elif part == "scaling":
        counts = scaling.COUNTS_FULL if full else scaling.COUNTS
        yield Task(part, "all", partial(scaling.scale, counts), ScalePoint)
    elif part == "effect calls":
        yield Task(part, "all", lambda: list(scene_calls()), SceneCalls)
    elif part == "effect costs":
        yield Task(part, "all", lambda: list(effect_costs()), EffectCost)


def _collect(record: Run, part: str, progress: Progress, journal: Journal | None) -> None:
    """Run the tasks of a part, or take them from the journal; one broken part must not hide the others."""
    into, seconds = getattr(record, FIELDS[part]), 0.0
    begun = time.perf_counter()
    try:
        planned = list(tasks(part, record.scope, record.expected))
        progress(part, 0, len(planned))
        for done, task in enumerate(planned, start=1):
            stored = journal.found.get((part, task.name)) if journal is not None else None
            if stored is not None:
                into += [revive(task.kind, data, task.declared) for data in stored["results"]]
                record.regimes.update(stored["regimes"])
                seconds += stored["seconds"]
                begun = time.perf_counter()
            else:
                results = task.compute()
                found = {r.case.id: _regimes(r, record) for r in results if isinstance(r, CaseResult)}
                took = time.perf_counter() - begun
                begun += took
                seconds += took
                into += results
                record.regimes.update(found)
                # A crash may have been the machine's: it is tried again by the next run.
                if journal is not None and all(getattr(r, "outcome", r) is not None for r in results):
                    journal.add(part, task.name, results, regimes=found, seconds=took)
            progress(part, done, len(planned))
    except Exception as error:
        record.failed_parts[part] = f"{type(error).__name__}: {error}"
    record.seconds[part] = seconds


def _regimes(result: CaseResult, record: Run) -> list[dict[str, Any]]:
    """Where a case lies in the domain of validity; nowhere if it was not solved or measured no accuracy."""
    if result.case.problem not in ACCURATE or result.outcome is None or result.outcome.solution is None:
        return []
    try:
        return regimes(result.outcome.solution)
    except Exception as error:  # the case stands; only the domain does not grow by it
        text = f"solved cases are missing from the domain of validity: {type(error).__name__}: {error}"
        if text not in record.notices:
            record.notices.append(text)
        return []


def _one_case(case: Case) -> list[CaseResult]:
    return [run_case(case)]


def _one_study(study: Study) -> list[StudyResult]:
    return [convergence.run_study(study)]


def _one_check(run_check: Callable[[], CheckResult]) -> list[CheckResult]:
    return [run_check()]


def _one_family(family: Family, full: bool) -> list[FamilyCost]:
    return [cost.measure(family, full)]


def _one_hard_case(case: HardCase, full: bool) -> list[HardResult]:
    return [hard_cases.run_hard_case(case, full)]
