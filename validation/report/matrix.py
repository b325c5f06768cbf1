"""Matrices of cases as tables: a row for every combination of the axes, a column for every quantity."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from validation.cases import Case, Reference
from validation.criteria import Finding, Limit, Verdict
from validation.problems import CaseResult


@dataclass(frozen=True)
class MatrixRow:
    """One case: its place on the axes and one cell for each column, None where it has no such quantity."""

    case: Case
    slug: str
    names: list[str]
    cells: list[Finding | None]
    verdict: Verdict
    reason: str
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Matrix:
    """One family whose cases are a matrix; `groups` are (heading, number of columns) above `columns`."""

    row: str
    slug: str
    title: str
    shows: str
    reference: Reference
    axes: list[str]
    groups: list[tuple[str, int]]
    columns: list[str]
    rows: list[MatrixRow]
    limits: list[Limit]


def matrices(results: Sequence[CaseResult]) -> list[Matrix]:
    """The matrices of a run, in the order of the case files."""
    families: dict[str, list[CaseResult]] = {}
    for result in results:
        if result.case.place:
            families.setdefault(result.case.row, []).append(result)
    return [_matrix(found) for found in families.values()]


def _matrix(results: list[CaseResult]) -> Matrix:
    first = results[0].case
    quantities = list(dict.fromkeys(f.quantity for r in results for f in r.findings))
    headings = [_split(quantity) for quantity in quantities]
    order = list(dict.fromkeys(group for group, _ in headings))
    columns = sorted(range(len(headings)), key=lambda i: order.index(headings[i][0]))
    groups = [(group, sum(g == group for g, _ in headings)) for group in order]
    rows = []
    for result in results:
        found = {f.quantity: f for f in result.findings}
        rows.append(
            MatrixRow(
                result.case,
                slug(result.case.id),
                list(result.case.place.values()),
                [found.get(quantities[i]) for i in columns],
                result.verdict,
                result.reason,
                list(result.outcome.notes) if result.outcome else [],
            )
        )
    limits = list(dict.fromkeys(limit for r in results for limit in r.case.limits))
    return Matrix(
        first.row, slug(first.row), first.family, first.shows, first.reference,
        list(first.place), groups, [headings[i][1] for i in columns], rows, limits,
    )  # fmt: skip


def _split(quantity: str) -> tuple[str, str]:
    """Heading and column of a quantity such as "tip position, 90, section"."""
    group, _, column = quantity.partition(", ")
    return group, column


def slug(name: Any) -> str:
    """A name as an anchor of the page."""
    return re.sub(r"[^a-zA-Z0-9]+", "-", str(name)).strip("-").lower()
