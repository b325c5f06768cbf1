"""Run the validation: cases, orders, properties, hard cases, studies; one record, one verdict."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import TypeVar

from validation import convergence, hard_cases, locking, property_runs, work_precision
from validation.cases import Case, load_cases
from validation.convergence import StudyResult
from validation.criteria import Limit, Verdict, judge, overall
from validation.environment import environment, versions
from validation.hard_cases import HardResult
from validation.locking import LockingPoint, SlendernessRow
from validation.problems import CaseResult, run_case
from validation.property_runs import PropertyResult
from validation.work_precision import FINE_SOLID_ERROR, FLOOR, WorkPoint

Result = TypeVar("Result")
Progress = Callable[[str, int, int], None]  # part, done, of how many

PARTS = ("cases", "convergence", "properties", "locking", "slenderness", "hard cases", "work-precision")
LOCKING = Limit(
    "EI ratio against its closed form", 1e-4, "-", "linear range, constant curvature: exact in one element"
)
SLENDERNESS = Limit(
    "distance from the documented table", 1.0, "2e-4 + 10 %", "two printed digits, another clamp at L/H = 20",
    kind="non-regression",
)  # fmt: skip


@dataclass
class Run:
    """Everything a run found."""

    scope: str
    started: str
    expected: list[Case] = field(default_factory=list)
    cases: list[CaseResult] = field(default_factory=list)
    convergence: list[StudyResult] = field(default_factory=list)
    properties: list[PropertyResult] = field(default_factory=list)
    locking: list[LockingPoint] = field(default_factory=list)
    slenderness: list[SlendernessRow] = field(default_factory=list)
    hard_cases: list[HardResult] = field(default_factory=list)
    work: list[WorkPoint] = field(default_factory=list)
    omissions: list[str] = field(default_factory=list)
    failed_parts: dict[str, str] = field(default_factory=dict)
    parts: tuple[str, ...] = PARTS
    selection: tuple[str, ...] = ()
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
        found |= {f"property {r.name}": r.verdict for r in self.properties}
        found |= {f"hard case {r.case.name}": r.verdict for r in self.hard_cases}
        found |= {name: finding.verdict for name, finding in self.study_findings.items()}
        return found | {f"part {name}": Verdict.FAIL for name in self.failed_parts}

    @property
    def study_findings(self) -> dict:
        """Checks of the studies that are one number each."""
        found = {}
        if self.locking:
            worst = max(abs(p.ratio / p.exact - 1.0) for p in self.locking)
            found["locking curve"] = judge(LOCKING, LOCKING.quantity, worst)
        if self.slenderness:
            worst = max(row.disagreement for row in self.slenderness)
            found["slenderness table"] = judge(SLENDERNESS, SLENDERNESS.quantity, worst)
        beams = [p for p in self.work if p.model == "3333"]
        if beams:
            found["work-precision"] = judge(FLOOR, FLOOR.quantity, beams[-1].error, FINE_SOLID_ERROR)
        return found

    @property
    def skipped(self) -> list[str]:
        """Required cases of the scope that were not run, and whole parts without a result."""
        done = {result.case.id for result in self.cases}
        missing = [case.id for case in self.expected if case.required and case.id not in done]
        results = (
            self.cases,
            self.convergence,
            self.properties,
            self.locking,
            self.slenderness,
            self.hard_cases,
            self.work,
        )
        empty = [name for name, found in zip(PARTS, results, strict=True) if name in self.parts and not found]
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


def run(
    scope: str = "quick",
    progress: Progress | None = None,
    wanted: tuple[str, ...] = (),
    parts: tuple[str, ...] = PARTS,
) -> Run:
    """Run the validation.

    Parameters
    ----------
    scope : ``quick`` or ``full`` (finer meshes, more examples)
    progress : called with the part, how much of it is done and of how many
    wanted : names of single cases; only they are run, and the run is not complete
    parts : which parts to run
    """
    full = scope == "full"
    started = time.perf_counter()
    record = Run(scope, datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"), parts=parts, selection=wanted)
    if wanted:
        record.parts = parts = ("cases",)
    report = progress or (lambda part, done, count: None)

    def collect(part: str, results: Iterator[Result], count: int, into: list[Result]) -> None:
        if part not in parts:
            return
        begin = time.perf_counter()
        report(part, 0, count)
        try:
            for done, result in enumerate(results, start=1):
                into.append(result)
                report(part, done, max(count, done))
        except Exception as error:  # one broken part must not hide the others
            record.failed_parts[part] = f"{type(error).__name__}: {error}"
        record.seconds[part] = time.perf_counter() - begin

    record.expected = select(load_cases(), scope, wanted) if "cases" in parts else []
    collect("cases", (run_case(case) for case in record.expected), len(record.expected), record.cases)
    studies = convergence.studies(full)
    collect("convergence", convergence.run(full), len(studies), record.convergence)
    examples, each = (200, 6.0) if full else (20, 1.2)
    collect("properties", property_runs.run(examples, each), 20, record.properties)
    collect("locking", iter_list(locking.locking_curve), 30, record.locking)
    collect("slenderness", iter_list(locking.slenderness_table), 6, record.slenderness)
    collect("hard cases", hard_cases.run(), len(hard_cases.hard_cases()), record.hard_cases)
    collect("work-precision", work_points(full), 13, record.work)
    record.seconds["total"] = time.perf_counter() - started
    return record


def iter_list(function: Callable[[], list[Result]]) -> Iterator[Result]:
    """Results of a function that gives a list, computed when the first is asked for."""
    yield from function()


def work_points(full: bool) -> Iterator[WorkPoint]:
    """Beams first, then the solid; repeats as the scope allows."""
    yield from work_precision.beam_points(20 if full else 7, full)
    yield from work_precision.solid_points(3 if full else 2, full)
