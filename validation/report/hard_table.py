"""The chapter of hard cases: a heat table of cases and measures, and behind each case how it was solved."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup, escape

from ancf.newton import Iteration
from validation.criteria import Finding, Verdict
from validation.hard_cases import HardResult
from validation.hard_limits import DRIFT, MEASURES, WALKED, Measure
from validation.report.history_plot import history_plot
from validation.report.matrix import slug
from validation.report.numbers import NOTHING, compact, number
from validation.scenes import as_toml

# Heat: class of a cell by log10(limit/found), from the least; what a margin is worth, not how large a number.
LEVELS = ((0.0, "h0"), (math.log10(1.5), "h1"), (1.0, "h2"), (3.0, "h3"), (6.0, "h4"))
LEGEND = (
    ("h0", "beyond the limit"),
    ("h1", "margin below 1.5"),
    ("h2", "below 10"),
    ("h3", "below 10³"),
    ("h4", "below 10⁶"),
    ("h5", "more, or an exact hit"),
)
GROUPS = {"drift": "drift of the shape, over L", "walk": "a hundred equal steps", "answer": "the answer"}
HEAD, TAIL = 12, 28  # rows of a long iteration history that are printed


@dataclass(frozen=True)
class Cell:
    """One number: as text, its heat class, and what a pointer says."""

    text: Markup
    heat: str
    title: str


@dataclass(frozen=True)
class HardRow:
    """A case as the template shows it; `left_out` counts the iterations that the table does not print."""

    result: HardResult
    slug: str
    cells: list[Cell]
    plot: Markup | None
    first: list[tuple[str, ...]]
    last: list[tuple[str, ...]]
    left_out: int
    toml: str


def chapter(results: Sequence[HardResult]) -> dict[str, Any]:
    """What the partial template `hard.html.j2` needs."""
    families: dict[str, list[HardRow]] = {}
    for result in results:
        families.setdefault(result.case.family, []).append(_row(result))
    return {
        "families": families,
        "measures": MEASURES,
        "groups": [(GROUPS[g], n) for g, n in _runs([_group(m) for m in MEASURES])],
        "legend": LEGEND,
        "passed": sum(r.verdict is not Verdict.FAIL for r in results),
        "total": len(results),
        "worst": _worst_drift(results),
        "wider": _wider_drifts(results),
    }


def heat(finding: Finding) -> str:
    """Class of a cell by the logarithm of its margin; a number that is missing is beyond its limit."""
    if finding.verdict in (Verdict.FAIL, Verdict.INCONCLUSIVE):
        return "h0"
    if finding.margin is None:
        return "h5"
    exponent = math.log10(finding.margin)
    return next((name for bound, name in LEVELS if exponent < bound), "h5")


def cell(measure: Measure, result: HardResult) -> Cell:
    """Cell of a measure: its number, coloured if it has a limit."""
    case, name = result.case, measure.name
    note = result.notes.get(name, "")
    if name in case.not_asked:
        return Cell(NOTHING, "hn", f"not asked: {case.not_asked[name]}")
    finding = next((f for f in result.findings if f.quantity == name), None)
    value = result.measured.get(name)
    if finding is None:
        if value is None:
            return Cell(NOTHING, "hn", note or "not in this run, or no answer is wanted")
        return Cell(number(value, 2), "", "; ".join(filter(None, [measure.meaning, note])))
    limit = f"{name} ≤ {finding.limit.value:.3g} {finding.limit.unit}: {finding.limit.reason}"
    if value is None:
        text = Markup("no number")
    elif measure.shows:
        order = result.measured.get(measure.shows)
        text = Markup("fast") if order is None else Markup(f"{order:.2f}")
    else:
        text = number(value, 2)
    return Cell(text, heat(finding), "; ".join(filter(None, [note, limit])))


def own_limits(result: HardResult) -> list[tuple[str, Markup, str, str]]:
    """Limits that only this case has: quantity, value, unit, reason."""
    return [(k.quantity, compact(k.value), k.unit, k.reason) for k in result.case.limits]


def _row(result: HardResult) -> HardRow:
    history = result.history
    lines = [_line(i + 1, entry) for i, entry in enumerate(history)]
    long = len(lines) > HEAD + TAIL
    name = slug(result.case.name)
    title = f"Residual and step against iteration: {result.case.name}"
    return HardRow(
        result,
        name,
        [cell(measure, result) for measure in MEASURES],
        history_plot(history, result.floor or 0.0, title) if history else None,
        lines[:HEAD] if long else lines,
        lines[-TAIL:] if long else [],
        len(lines) - HEAD - TAIL if long else 0,
        as_toml(result.case.scene),
    )


def _line(number: int, entry: Iteration) -> tuple[str, ...]:
    """An iteration as the words of a table row."""
    sizes = [f"{v:.1e}" if math.isfinite(v) else "not finite" for v in (entry.residual, entry.step)]
    return (str(number), f"{entry.load_factor:.6g}", str(entry.iteration), *sizes)


def _group(measure: Measure) -> str:
    if measure.name in WALKED:
        return "walk"
    return "drift" if measure.name.startswith("drift") or measure.name == "ulp ratio" else "answer"


def _runs(values: list[str]) -> list[tuple[str, int]]:
    """Equal neighbours counted."""
    found: list[tuple[str, int]] = []
    for value in values:
        if found and found[-1][0] == value:
            found[-1] = (value, found[-1][1] + 1)
        else:
            found.append((value, 1))
    return found


def _wider_drifts(results: Sequence[HardResult]) -> list[str]:
    """Cases whose limit of a drift is wider than that of all."""
    return [
        r.case.name
        for r in results
        if any(limit.quantity.startswith("drift") and limit.value > DRIFT for limit in r.case.limits)
    ]


def _worst_drift(results: Sequence[HardResult]) -> Markup | None:
    """The largest drift of all, in words."""
    found = [
        (f.observed, f.quantity, r.case.name)
        for r in results
        for f in r.findings
        if f.quantity.startswith("drift") and f.observed is not None
    ]
    if not found:
        return None
    value, quantity, name = max(found)
    return Markup("{} L ({}; {})").format(number(value, 2), escape(quantity), escape(name))
