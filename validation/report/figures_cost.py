"""Figures of what accuracy costs: error against time, unknowns and iterations, log-log, a panel a family."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from validation.cost.points import CostPoint
from validation.cost.run import FamilyCost
from validation.report.style import (
    ELEMENT_MARKS,
    GREEN,
    INK,
    MUTED,
    RED,
    SKY,
    VIOLET,
    new_figure,
    to_svg,
)

if TYPE_CHECKING:
    from validation.cost.ladder import SceneCost

COLUMNS = 3
LOWEST = 1e-6  # smaller errors, which only the references have, are drawn there with their size
COUNTS = (3, 5, 10, 20, 50, 100, 200)
# Known models keep their mark; any other takes the next of the spare ones.
MARKS: dict[str, tuple[str, str, str]] = {
    **ELEMENT_MARKS,
    "solid hex27": ("D", GREEN, ":"),
    "section problem": ("*", INK, ":"),
    "rod": ("X", INK, ":"),
    "exudyn ANCFCable2D": ("<", MUTED, "-"),
    "exudyn ANCFCable": (">", MUTED, "--"),
    "exudyn GeometricallyExactBeam": ("h", "#8a6d3b", "-."),
    "soromox PCS": ("H", "#4d7c4d", "--"),
    "exudyn ANCFBeam": ("p", "#b0894f", ":"),
}
SPARE = (("<", GREEN, "-"), (">", RED, "--"), ("h", SKY, "--"), ("p", VIOLET, ":"))
AXES: dict[str, tuple[str, Callable[[CostPoint], float]]] = {
    "seconds": ("CPU time of one solution [ms]", lambda p: 1e3 * p.median),
    "unknowns": ("unknowns", lambda p: float(p.unknowns)),
    "iterations": ("linear solves", lambda p: float(p.iterations)),
}


def grid(costs: Sequence[FamilyCost], against: str) -> Markup:
    """Error of the tip against one of `AXES`, a panel a family, with the legend in the last place."""
    lines = math.ceil((len(costs) + 1) / COLUMNS)
    figure = new_figure(9.4, 2.75 * lines)
    axes = figure.subplots(lines, COLUMNS, squeeze=False).ravel()
    labels = [_panel(ax, cost, against) for ax, cost in zip(axes, costs, strict=False)]
    for ax in axes[len(costs) :]:
        ax.axis("off")
    _legend(axes[len(costs)], {name for found in labels for name in found}, against)
    for ax in axes[0 : len(costs) : COLUMNS]:
        ax.set_ylabel("tip error / L")
    for ax in axes[max(len(costs) - COLUMNS, 0) : len(costs)]:
        ax.set_xlabel(AXES[against][0])
    return to_svg(figure, f"cost-{against}", f"Tip error against {AXES[against][0]} in {len(costs)} families")


def family_figure(cost: FamilyCost) -> Markup:
    """One family: error against time, unknowns and iterations, side by side."""
    figure = new_figure(11.5, 3.6)
    axes = figure.subplots(1, 4, width_ratios=[3, 3, 3, 2])
    names: set[str] = set()
    for ax, against in zip(axes, AXES, strict=False):
        names |= _panel(ax, cost, against)
        ax.set_xlabel(AXES[against][0])
        ax.set_title("", loc="left")
    axes[0].set_ylabel("tip error / L")
    axes[-1].axis("off")
    _legend(axes[-1], names, "seconds")
    figure.suptitle(cost.name)
    return to_svg(figure, "cost-family", f"Tip error against cost, {cost.name}")


def scene_figure(cost: SceneCost) -> Markup:
    """The ladders of one scene: error with its bar against time."""
    figure = new_figure(6.4, 4.0)
    ax = figure.subplots()
    for ladder in cost.ladders:
        points = [p for p in ladder.points if p.error is not None]
        marker, colour, line = _mark(ladder.element)
        x = [1e3 * p.median for p in points]
        ax.plot(
            x, [p.error or 0.0 for p in points], marker=marker, color=colour, ls=line, label=ladder.element
        )
        for p, here in zip(points, x, strict=True):
            _name(ax, str(p.elements), here, p.error or 0.0, colour)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel(AXES["seconds"][0])
    ax.set_ylabel("error of the tip / L, error bar included")
    ax.grid(visible=True)
    ax.margins(0.12)
    ax.legend(loc="upper right")
    return to_svg(figure, "cost-scene", "Error of the tip against time, by element")


def _panel(ax: Any, cost: FamilyCost, against: str) -> set[str]:
    """Draw a family; the models drawn."""
    value = AXES[against][1]
    drawn: set[str] = set()
    settings = list(dict.fromkeys(p.setting for p in cost.points))
    for setting in settings:
        points = [p for p in cost.points if p.setting == setting]
        if against != "seconds" and points[0].kind not in ("beam", "solid"):
            continue  # other programs do not say how many linear solves they took
        model = points[0].model
        default = setting == next(s for s in settings if s[0] == model)
        marker, colour, line = _mark(model)
        good = [p for p in points if p.converged and p.error is not None]
        hollow = {} if default else {"markerfacecolor": "white", "markersize": 4.5, "alpha": 0.8, "lw": 0.9}
        ax.plot(
            [value(p) for p in good], [max(p.error or 0.0, LOWEST) for p in good],
            marker=marker, color=colour, ls=line if default else ":", **hollow,
        )  # fmt: skip
        for p in points:
            if not p.converged and value(p) > 0.0:
                ax.plot(value(p), 0.97, "x", color=colour, transform=ax.get_xaxis_transform(), ms=6, mew=1.8)
        for p in good:
            if (p.error or 0.0) < LOWEST:
                _name(ax, f"below: {p.error:.0e}", value(p), LOWEST, colour, (-4, 8))
        if default and points[0].kind == "beam" and good:
            for p in (good[0], good[-1]):
                _name(ax, str(p.elements), value(p), p.error or 0.0, colour)
        drawn.add(model)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_ylim(0.6 * LOWEST, 3.0)
    ax.set_title(cost.name, loc="left")
    ax.grid(visible=True)
    ax.margins(x=0.1)
    if against == "iterations":
        ax.set_xlim(2.5, 300.0)
        ax.set_xticks(COUNTS, [str(count) for count in COUNTS])
        ax.minorticks_off()
    return drawn


def _mark(model: str) -> tuple[str, str, str]:
    """Marker, colour and line of a model, the same in every figure."""
    return MARKS.get(model, SPARE[sum(model.encode()) % len(SPARE)])


def _name(ax: Any, text: str, x: float, y: float, colour: str, offset: tuple[int, int] = (4, 3)) -> None:
    side = "left" if offset[0] > 0 else "right"
    ax.annotate(text, (x, y), xytext=offset, ha=side, textcoords="offset points", fontsize=7.5, color=colour)


def _legend(ax: Any, names: set[str], against: str) -> None:
    for model in [m for m in MARKS if m in names] + sorted(names - set(MARKS)):
        marker, colour, line = _mark(model)
        label = model.replace("GeometricallyExactBeam", "geometrically exact")
        ax.plot([], [], marker=marker, color=colour, ls=line, label=label)
    ax.plot([], [], "o", color=MUTED, markerfacecolor="white", ms=4.5, label="other setting or formulation")
    ax.plot([], [], "x", color=MUTED, mew=1.8, label="no equilibrium found")
    ax.legend(loc="center left", fontsize=8)
