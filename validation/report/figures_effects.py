"""Bars: what one assembly of each effect costs by the elastic assembly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from validation.effect_costs import ASKED, EffectCost
from validation.report.style import GREEN, INK, ORANGE, SKY, new_figure, to_svg


def cost_bars(costs: Sequence[EffectCost]) -> Markup:
    """Bars for each effect, by the number of elements, with the limit that was asked for."""
    names = list(dict.fromkeys(cost.effect for cost in costs))
    meshes = list(dict.fromkeys(cost.elements for cost in costs))
    figure = new_figure(7.2, 0.8 + 0.18 * len(names) * len(meshes))
    ax = figure.subplots()
    height = 0.8 / len(meshes)
    for index, (mesh, colour) in enumerate(zip(meshes, (ORANGE, SKY, GREEN), strict=False)):
        found = {cost.effect: cost.ratio for cost in costs if cost.elements == mesh}
        y = np.arange(len(names)) + (index - 0.5 * (len(meshes) - 1)) * height
        ax.barh(
            y, [found.get(name, np.nan) for name in names], height, color=colour, label=f"{mesh} elements"
        )
    ax.axvline(ASKED, color=INK, linestyle=":", label=f"{ASKED:.0%}")
    ax.set_yticks(range(len(names)), names)
    ax.invert_yaxis()
    ax.set_xscale("log")
    ax.set_xlabel("time of its assembly / elastic assembly")
    ax.legend(loc="lower right", frameon=False)
    return to_svg(figure, "effects", "Cost of each effect by the elastic assembly")
