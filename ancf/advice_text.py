"""Advice as people read it: a table of dimensionless numbers, and one of effects and choices."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ancf.advice import Advice
from ancf.influence import Influence

MEANING = {
    "gravity": "weight L^2/EI",
    "slenderness": "L/R",
    "shear": "EI/(GA L^2)",
    "extension": "EI/(EA L^2)",
    "force": "largest load, P L^2/EI",
    "moment": "largest load, M L/EI",
    "section_force": "largest in a section, N L^2/EI",
    "section_moment": "largest in a section, M L/EI",
    "section_strain": "largest strain",
    "contact_distance": "smallest gap/L",
}
MOST_RODS = 6  # beside each other; of more the range is shown
NOTHING = 1e-9  # of the length: rounding


def advice_lines(advice: Advice) -> Iterator[str]:
    """Lines of both tables."""
    yield "numbers:"
    yield from _aligned(_numbers(advice))
    source = "" if advice.asked else " (default; [solver] accuracy sets it)"
    yield f"advice at {advice.accuracy:g} of the length{source}:"
    if advice.state != "equilibrium":
        yield (
            f"  no equilibrium was found ({advice.status}): estimates are those of small loads on the"
            " unloaded shape; `ancf solve` says more"
        )
    rows = [["effect", "listed", "moves the tip by", "number", "advice"]]
    rows += [_row(one) for one in (*advice.listed, *advice.missing, *advice.choices)]
    yield from _aligned(rows)


def _numbers(advice: Advice) -> list[list[str]]:
    rods = list(advice.numbers)
    known = [key for key in MEANING if any(advice.numbers[rod].get(key) for rod in rods)]
    rows = [["", "", *rods]] if len(rods) <= MOST_RODS else [["", "", "least", "most of all rods"]]
    for key in known:
        values = [advice.numbers[rod].get(key) for rod in rods]
        if len(rods) > MOST_RODS:
            there = [value for value in values if value is not None]
            values = [min(there), max(there)]
        rows.append([key.replace("_", " "), MEANING[key], *(_number(value) for value in values)])
    return rows


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}" if abs(value) > NOTHING else "0"


def _row(one: Influence) -> list[str]:
    number = "" if one.number is None else f"{one.measure} {_number(one.number)}"
    advice = f"{one.advice} ({one.note})" if one.note else one.advice
    return [one.effect, one.listed, _shift(one), number, advice]


def _shift(one: Influence) -> str:
    """The shift of the tip in lengths, and that of the rod where the tip does not show it."""
    if one.largest is None:
        return "?"
    about = "~" if one.first_order and one.largest > NOTHING else ""
    if one.tip is None:
        return f"> {one.largest:.1g} L"
    if one.largest > 1.0 and one.first_order:
        return "> 1 L"
    if one.largest <= NOTHING:
        return "0"
    if one.tip <= NOTHING:
        return f"held; rod {about}{one.largest:.2g} L"
    elsewhere = f"; rod {about}{one.largest:.2g} L" if one.largest > 2.0 * one.tip else ""
    return f"{about}{one.tip:.2g} L{elsewhere}"


def _aligned(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Lines of a table, columns as wide as their widest cell."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        yield "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
