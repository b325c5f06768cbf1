"""Figures of the studies: margins, convergence, locking."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from validation.convergence import StudyResult
from validation.criteria import WARN_MARGIN, Verdict
from validation.locking import LockingPoint
from validation.problems import CaseResult
from validation.report.style import (
    BLUE,
    ELEMENT_MARKS,
    FAINT,
    GREEN,
    INK,
    MUTED,
    ORANGE,
    RED,
    VIOLET,
    new_figure,
    to_svg,
)

DOTS = {
    Verdict.PASS: ("o", BLUE),
    Verdict.WARN: ("^", ORANGE),
    Verdict.KNOWN_LIMIT: ("D", VIOLET),
    Verdict.FAIL: ("X", RED),
    Verdict.INCONCLUSIVE: ("X", RED),
}
LARGEST_MARGIN = 1e4  # larger ones are drawn at the edge


def margins(results: Sequence[CaseResult]) -> Markup:
    """Every reference check as a dot at its margin, by row of the benchmark table."""
    judged = [r for r in results if any(f.limit.kind == "reference" for f in r.findings)]
    titles: dict[str, str] = {}
    for r in judged:
        titles.setdefault(r.case.row, r.case.family)
    rows = list(titles)
    figure = new_figure(9.2, 0.42 + 0.27 * len(rows) + 0.5)
    axes = figure.add_subplot()
    dots: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for result in results:
        for f in (f for f in result.findings if f.limit.kind == "reference"):
            x = LARGEST_MARGIN if f.margin is None else float(np.clip(f.margin, 1e-3, LARGEST_MARGIN))
            dots.setdefault(DOTS[f.verdict], []).append((x, float(rows.index(result.case.row))))
    for (marker, colour), points in dots.items():
        axes.plot(
            *zip(*points, strict=True), marker, color=colour, alpha=0.75, markersize=6, markeredgewidth=0
        )
    axes.axvline(1.0, color=INK, lw=1.2)
    axes.axvline(WARN_MARGIN, color=MUTED, lw=0.9, ls=(0, (4, 3)))
    axes.set_xscale("log")
    axes.set_xlim(7e-4, LARGEST_MARGIN * 1.8)
    axes.set_yticks(range(len(rows)), [f"{titles[row]}  ({row})" for row in rows])
    axes.set_ylim(len(rows) - 0.4, -1.1)
    axes.text(0.93, -0.75, "misses", ha="right", fontsize=9, color=MUTED)
    axes.text(1.62, -0.75, "meets its limit, with this much to spare", ha="left", fontsize=9, color=MUTED)
    axes.grid(axis="x")
    axes.set_axisbelow(True)
    axes.set_xlabel("margin = limit / observed deviation")
    return to_svg(figure, "margins", "Margin of every reference check, by benchmark row")


def convergence(results: Sequence[StudyResult]) -> Markup:
    """One panel a problem: error against elements of each kind, with the promised slopes."""
    names = list(dict.fromkeys(r.study.name for r in results))
    columns = 3
    lines = math.ceil((len(names) + 1) / columns)
    figure = new_figure(7.4, 2.35 * lines)
    axes = figure.subplots(lines, columns, squeeze=False).ravel()
    for ax, name in zip(axes, names, strict=False):
        for result in (r for r in results if r.study.name == name):
            marker, colour, line = ELEMENT_MARKS[result.study.element]
            n, e = np.array(result.study.meshes, float), np.array(result.errors)
            ax.loglog(n, e, marker=marker, color=colour, ls=line)
            guide = e[-1] * (n / n[-1]) ** -result.study.promised
            ax.loglog(n, guide, color=FAINT, lw=3.5, zorder=0)
            ax.annotate(
                f"{result.slope:.1f}", (n[-1], e[-1]), xytext=(5, -3),
                textcoords="offset points", color=colour,
                fontsize=9,
                fontweight="bold",
            )  # fmt: skip
        ax.set_title(name, loc="left")
        ticks = [1, 2, 4, 8, 16, 32, 64]
        ax.set_xticks(ticks, [str(n) for n in ticks])
        ax.minorticks_off()
        ax.set_xlim(0.8, 100)
        ax.grid(visible=True)
    for ax in axes[len(names) :]:
        ax.axis("off")
    legend = axes[len(names)]
    studied = {result.study.element for result in results}
    for element in (name for name in ELEMENT_MARKS if name in studied):
        marker, colour, line = ELEMENT_MARKS[element]
        legend.plot([], [], marker=marker, color=colour, ls=line, label=f"element {element}")
    legend.plot([], [], color=FAINT, lw=3.5, label="promised slope")
    legend.legend(loc="center left", fontsize=10)
    legend.text(0.02, 0.1, "bold: fitted order", transform=legend.transAxes, fontsize=9, color=MUTED)
    for ax in axes[0::columns]:
        if ax.axison:
            ax.set_ylabel("error / L, or rad")
    for ax in axes[max(len(names) - columns, 0) : len(names)]:
        ax.set_xlabel("elements")
    return to_svg(
        figure, "convergence", "Error against number of elements in five problems, with fitted orders"
    )


def locking(points: Sequence[LockingPoint]) -> Markup:
    """EI_eff/EI over Poisson's ratio: closed forms as lines, the solver as marks."""
    figure = new_figure(7.0, 3.3)
    axes = figure.add_subplot()
    nu = np.linspace(0.0, 0.499, 300)
    axes.semilogy(nu, (1 - nu) / ((1 + nu) * (1 - 2 * nu)), color=ORANGE, lw=1.6)
    axes.axhline(1.0, color=BLUE, lw=1.6)
    styles = {
        ("3243", "continuum"): ("s", ORANGE, "paper: 3243, full Hooke"),
        ("3243", "enhanced"): ("D", GREEN, "3243, enhanced"),
        ("3333", "enhanced"): ("o", BLUE, "3333, enhanced (default)"),
    }
    for key, (marker, colour, label) in styles.items():
        found = [p for p in points if (p.element, p.formulation) == key]
        hollow = {"markerfacecolor": "white", "markeredgewidth": 1.6} if key == ("3243", "enhanced") else {}
        size = 9 if hollow else 6
        axes.plot(
            [p.poisson_ratio for p in found],
            [p.ratio for p in found],
            marker,
            color=colour,
            label=label,
            ms=size,
            **hollow,
        )
    for x, text in ((0.3, "1.346"), (0.45, "3.793"), (0.49, "17.11")):
        value = (1 - x) / ((1 + x) * (1 - 2 * x))
        axes.annotate(
            text,
            (x, value),
            xytext=(-8, 5),
            textcoords="offset points",
            ha="right",
            color=ORANGE,
            fontsize=9.5,
        )
    axes.set_yticks([1, 2, 5, 10, 20, 50, 100], ["1", "2", "5", "10", "20", "50", "100"])
    axes.minorticks_off()
    axes.set_ylim(0.8, 250)
    axes.set_xlim(-0.01, 0.52)
    axes.set_xlabel("Poisson's ratio")
    axes.set_ylabel("bending stiffness found / E I")
    axes.grid(visible=True)
    axes.legend(loc="upper left")
    return to_svg(figure, "locking", "Effective bending stiffness over Poisson's ratio")
