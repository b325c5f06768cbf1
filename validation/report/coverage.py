"""What was compared with what: the matrix of elements, laws, loads and kinds of reference, "
"empty cells included."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from validation.cases import INDEPENDENCE, Case
from validation.certificate import domain_of_run
from validation.domain import ROD
from validation.problems import CaseResult
from validation.runner import Run

LETTERS = {
    "closed form": "C", "section problem": "S", "3-D solid": "D", "rod integration": "R", "other code": "O",
    "identity": "I",
}  # fmt: skip
LOADS = (
    "tip moment", "follower moment", "torsion", "tip force", "follower force", "axial force",
    "line load", "gravity",
    "prescribed strain", "none",
)  # fmt: skip


def coverage(results: Sequence[CaseResult]) -> dict[str, Any]:
    """Cases by element, law and load, with the kinds of reference; empty cells stay visible."""
    cells: dict[tuple[str, str], Counter[str]] = {}
    for result in results:
        letter = LETTERS.get(result.case.reference.independence)
        if letter is None:
            continue
        for name in _combinations(result.case):
            for load in result.case.loads.split(", "):
                cells.setdefault((name, load), Counter())[letter] += 1
    named = {name for result in results for name in _combinations(result.case)}
    rows = [f"{e}, {law}" for e in ("3333", "3243") for law in ("enhanced", "continuum")]
    rows += sorted(named - set(rows))
    loads = [*LOADS, *sorted({load for _, load in cells} - set(LOADS))]
    found = Counter(r.case.reference.independence for r in results)
    checks = Counter()
    for r in results:
        checks[r.case.reference.independence] += len(r.findings)
    return {
        "loads": ["rigid motion" if load == "none" else load for load in loads],
        "rows": [
            {"name": name, "cells": [_cell(cells.get((name, load))) for load in loads]} for name in rows
        ],
        "kinds": [
            {"name": name, "meaning": meaning, "cases": found[name], "checks": checks[name]}
            for name, meaning in INDEPENDENCE.items()
        ],
    }  # fmt: skip


def domain_rows(run: Run) -> list[dict[str, Any]]:
    """Domain of validity of a run, a row for each element, law and set of loads: ranges, largest numbers."""
    groups: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for entry in domain_of_run(run):
        groups.setdefault(tuple(entry[key] for key in (*ROD, "loads")), []).append(entry)
    rows = []
    for names, entries in groups.items():
        row: dict[str, Any] = dict(zip((*ROD, "loads"), names, strict=True))
        for key in ("slenderness", "poisson_ratio", "elements"):
            row[key] = [min(entry[key][0] for entry in entries), max(entry[key][1] for entry in entries)]
        row["sections"] = ", ".join(sorted({entry["section"] for entry in entries}))
        row["largest"] = {}
        for entry in entries:
            for name, column in zip(entry["numbers"], zip(*entry["front"], strict=True), strict=True):
                row["largest"][name] = max(row["largest"].get(name, 0.0), *column)
        rows.append(row)
    return rows


def _cell(counts: Counter[str] | None) -> str:
    return (
        ""
        if not counts
        else " ".join(f"{letter}{counts[letter]}" for letter in LETTERS.values() if counts[letter])
    )


def _combinations(case: Case) -> set[str]:
    """Element and law of a case; several where it has variants."""
    if case.problem == "ladder":
        return set()  # references among themselves
    return {
        f"{element}, {formulation}" + ("" if law == "saint-venant-kirchhoff" else f", {law}")
        for element, formulation, law in case.combinations
    }
