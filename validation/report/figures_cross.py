"""Figures of the cross-check: shapes of beam and solid, a section's stress, the rate of the gap."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from validation.exact import answer
from validation.problems import CaseResult
from validation.problems_cross import loaded
from validation.problems_stress import beam_stress, middle_stress
from validation.report.style import BLUE, FAINT, GREEN, INK, MUTED, ORANGE, SKY, VIOLET, new_figure, to_svg
from validation.scenes import changed, solve

Floats = NDArray[np.float64]

RUBBER = {"law": "neo-hookean", "young_modulus": 1.0e6, "poisson_ratio": 0.49}
ARM: dict[str, Any] = {
    "rod": [
        {
            "length": 0.4, "elements": 16, "element": "3363",
            "section": {"shape": "circle", "radius": 0.01}, "material": RUBBER,
            "supports": [{"at": 0.0, "kind": "free_section_clamp"}],
        }
    ]
}  # fmt: skip
ANGLES = (90, 180)  # degrees; both are cases of the solid, so their answers are stored
STRESS_ANGLE = 180
STYLES = {"3333": ("o", BLUE), "3243": ("s", ORANGE), "3363": ("D", GREEN)}
LAW_STYLES = (("o", BLUE), ("s", ORANGE), ("D", GREEN), ("^", VIOLET), ("v", SKY))


def overlay() -> Markup | None:
    """Centre lines: solid as a line, beam 3363 as marks, with the gap magnified below."""
    figure = new_figure(9.2, 3.9)
    shape, gap = figure.subplots(1, 2, width_ratios=(1.1, 1.0))
    drawn = False
    for angle, colour in zip(ANGLES, (BLUE, ORANGE), strict=True):
        scene = loaded(ARM, "bending", angle)
        exact = answer("solid", scene)
        if exact.reason:
            continue
        drawn = True
        s, axis = np.array(exact.values["axis"]["s"]), np.array(exact.values["axis"]["position"])
        shape.plot(axis[:, 0], axis[:, 1], color=colour, lw=5, alpha=0.3, solid_capstyle="butt")
        for element in ("3363", "3333"):
            solution = solve(changed(scene, {"element": element}))
            found = solution.displaced(None, s, 0.0, 0.0) / 0.4
            distance = np.linalg.norm(found - axis, axis=1)
            marker, _ = STYLES[element]
            if element == "3363":
                shape.plot(found[::4, 0], found[::4, 1], marker, color=colour, ms=4)
                shape.annotate(
                    f"{angle}°",
                    axis[len(axis) // 2, :2],
                    xytext=(8, -8),
                    textcoords="offset points",
                    color=colour,
                )
            gap.semilogy(
                s[1:], distance[1:], "-" if element == "3363" else "--", color=colour,
                label=f"{element}, {angle}°",
            )  # fmt: skip
    if not drawn:
        return None
    shape.set_aspect("equal")
    shape.set_xlabel("x/L")
    shape.set_ylabel("y/L")
    shape.set_title("lines: solid; marks: 16 elements 3363", color=MUTED)
    gap.set_xlabel("s/L")
    gap.set_title("distance of the centre lines / L", color=MUTED)
    gap.grid(axis="y")
    gap.legend()
    return to_svg(figure, "overlay", "Centre lines of beam and solid bent to 90 and 180 degrees")


def stress() -> Markup | None:
    """Axial Cauchy stress of the middle section of solid and beams, one colour scale."""
    scene = loaded(ARM, "bending", STRESS_ANGLE)
    exact = middle_stress(scene)
    if exact.reason:
        return None
    points, solid = exact.points, exact.solid
    panels = {"solid, hex27": solid}
    for element in ("3363", "3333"):
        panels[f"beam {element}"] = beam_stress(solve(changed(scene, {"element": element})), points)
    modulus = RUBBER["young_modulus"]
    top = max(float(np.max(np.abs(values))) for values in panels.values()) / modulus
    figure = new_figure(9.2, 3.4)
    levels = np.linspace(-top, top, 22)
    for axes, (name, values) in zip(figure.subplots(1, 3), panels.items(), strict=True):
        shown = axes.tricontourf(
            points[:, 1] * 1e3, points[:, 0] * 1e3, values / modulus, levels, cmap="RdBu_r"
        )
        worst = float(np.max(np.abs(values - solid))) / modulus
        note = "" if name.startswith("solid") else f"\nlargest difference {worst:.4f} E"
        axes.set_title(f"{name}{note}", color=INK)
        axes.set_aspect("equal")
        axes.set_xlabel("z, mm")
    figure.colorbar(shown, ax=figure.axes, shrink=0.72, format="%.2f", label="axial stress / E",
                    ticks=np.round(np.linspace(-0.75 * top, 0.75 * top, 7), 2))  # fmt: skip
    figure.axes[0].set_ylabel("y, mm")
    return to_svg(figure, "stress", "Axial Cauchy stress of the middle section: solid, 3363, 3333")


def rates(results: Sequence[CaseResult]) -> Markup | None:
    """Distance of beam tips from the exact section problem against kappa R, with the slope of order 2."""
    found = [
        (r.case, r.outcome.rows)
        for r in results
        if r.case.problem == "gap rate" and r.outcome is not None and r.outcome.rows
    ]
    if not found:
        return None
    figure = new_figure(9.2, 3.8)
    panels = dict(zip(STYLES, figure.subplots(1, 3, sharex=True, sharey=True), strict=True))
    laws: list[str] = []
    for case, rows in found:
        radii = np.array(case.parameters["radii"])
        length, angle = case.rod["length"], math.radians(case.parameters["sizes"][0])
        gaps = [row.found for row in rows[: len(radii)]]
        element, law = case.place["element"], case.place["law"]
        laws += [law] if law not in laws else []
        marker, colour = LAW_STYLES[laws.index(law) % len(LAW_STYLES)]
        panels[element].loglog(angle * radii / length, gaps, marker=marker, color=colour, lw=1.2, label=law)
    first = panels["3333"]
    kappa = np.array(first.get_xlim()) * [1.1, 0.9]
    ticks = [0.02, 0.04, 0.08]
    for element, axes in panels.items():
        axes.loglog(kappa, 0.05 * kappa**2, color=FAINT, lw=3, zorder=0)
        axes.set_title(element)
        axes.grid(which="both", axis="both")
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.set_xticks([], minor=True)
    first.text(kappa[1], 0.03 * kappa[1] ** 2, "order 2", color=MUTED, va="top", ha="right", fontsize=9)
    first.set_ylabel("distance of the tip / L")
    panels["3243"].set_xlabel("κR, surface strain of the thin rod")
    panels["3363"].legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    return to_svg(figure, "rates", "Distance of the beam from the exact section problem against kappa R")


__all__ = ["overlay", "rates", "stress"]
