"""How a case was solved, as a small drawing: residual and step of every iteration, by Newton run."""

from __future__ import annotations

import math
from collections.abc import Sequence

from markupsafe import Markup, escape

from ancf.newton import Iteration
from validation.report.style import BLUE, FAINT, INK, MUTED, ORANGE

WIDTH, HEIGHT = 620, 210
LEFT, RIGHT, TOP, BOTTOM = 46, 8, 18, 30
LOWEST, HIGHEST = -18, 12  # decades that are drawn; what lies outside is drawn on the border
MARKED = 60  # iterations up to which each has a mark


def history_plot(history: Sequence[Iteration], floor: float, title: str) -> Markup:
    """Inline SVG: log10 of residual (blue, round) and step (orange, square) against iteration.

    A thin vertical line stands where a Newton run begins, with its load factor; the dashed level is the floor
    of the residual. Colours differ in lightness and the marks in shape.
    """
    low, high = _decades([v for h in history for v in (h.residual, h.step)])
    count = len(history)

    def x(index: float) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * (index + 0.5) / count

    def y(value: float) -> float:
        exponent = (
            math.log10(value) if value > 0.0 and math.isfinite(value) else (low if value <= 0.0 else high)
        )
        share = (min(max(exponent, low), high) - low) / (high - low)
        return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * share

    parts = [_grid(low, high, y)]
    begins = [i for i, entry in enumerate(history) if entry.iteration == 1]
    labelled = begins if len(begins) <= 12 else begins[:: len(begins) // 12 + 1]
    for i in begins:
        at = f"{x(i - 0.5):.1f}"
        parts.append(f'<path d="M{at} {TOP}V{HEIGHT - BOTTOM}" stroke="{MUTED}" stroke-width=".6"/>')
        if i in labelled:
            factor = f"{history[i].load_factor:.3g}"
            parts.append(f'<text x="{at}" y="{TOP - 5}" fill="{MUTED}">{factor}</text>')
    if floor > 0.0:
        level = f"{y(floor):.1f}"
        parts.append(
            f'<path d="M{LEFT} {level}H{WIDTH - RIGHT}" stroke="{BLUE}" stroke-width=".8" '
            'stroke-dasharray="4 3"/>'
        )
    for values, colour, square in (
        ([h.residual for h in history], BLUE, False),
        ([h.step for h in history], ORANGE, True),
    ):
        points = [(x(i), y(value)) for i, value in enumerate(values)]
        parts.append(_lines(points, begins, colour))
        if count <= MARKED:
            parts += [_mark(*point, colour, square) for point in points]
    parts.append(
        f'<text x="{(WIDTH + LEFT) / 2}" y="{HEIGHT - 4}" text-anchor="middle" fill="{INK}">iteration, 1 to '
        f"{count}; above: load factor of each Newton run; "
        f'<tspan fill="{BLUE}">● residual</tspan>, <tspan fill="{ORANGE}">■ step</tspan></text>'
    )
    return Markup(
        f'<svg class="plot history" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" role="img" '
        f'aria-label="{escape(title)}" font-size="10">' + "".join(parts) + "</svg>"
    )


def _decades(values: list[float]) -> tuple[int, int]:
    """Whole decades around the positive values."""
    exponents = [math.log10(v) for v in values if v > 0.0 and math.isfinite(v)] or [0.0]
    low = max(math.floor(min(exponents)), LOWEST)
    high = min(math.ceil(max(exponents)), HIGHEST)
    return min(low, HIGHEST - 1), max(high, low + 1)


def _grid(low: int, high: int, y) -> str:
    every = max(1, math.ceil((high - low) / 6))
    lines = []
    for exponent in range(low, high + 1, every):
        level = y(10.0**exponent)
        lines.append(f'<path d="M{LEFT} {level:.1f}H{WIDTH - RIGHT}" stroke="{FAINT}" stroke-width=".5"/>')
        lines.append(
            f'<text x="{LEFT - 5}" y="{level + 3:.1f}" text-anchor="end" fill="{INK}">1e{exponent}</text>'
        )
    return "".join(lines)


def _lines(points: list[tuple[float, float]], begins: list[int], colour: str) -> str:
    """Connected within one Newton run only."""
    words = [f"{'M' if i in begins or i == 0 else 'L'}{a:.1f} {b:.1f}" for i, (a, b) in enumerate(points)]
    return f'<path d="{"".join(words)}" fill="none" stroke="{colour}" stroke-width="1.3"/>'


def _mark(a: float, b: float, colour: str, square: bool) -> str:
    if square:
        return f'<rect x="{a - 2:.1f}" y="{b - 2:.1f}" width="4" height="4" fill="{colour}"/>'
    return f'<circle cx="{a:.1f}" cy="{b:.1f}" r="2.3" fill="{colour}"/>'
