"""Figures of the cross-check: shapes of beam and solid, a section's stress, the rate of the gap."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from validation.exact import Answer, answer
from validation.problems import CaseResult
from validation.problems_cross import loaded
from validation.report.style import BLUE, FAINT, GREEN, INK, MUTED, ORANGE, VIOLET, new_figure, to_svg
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
                shape.plot(found[::4, 0], found[::4, 1], marker, color=colour, ms=4, label=f"{angle}°")
            gap.semilogy(
                s[1:], distance[1:], "-" if element == "3363" else "--", color=colour,
                label=f"{element}, {angle}°",
            )  # fmt: skip
    if not drawn:
        return None
    shape.set_aspect("equal")
    shape.set_xlabel("x/L")
    shape.set_ylabel("y/L")
    shape.legend(loc="lower left")
    shape.set_title("lines: solid; marks: 16 elements 3363", color=MUTED)
    gap.set_xlabel("s/L")
    gap.set_title("distance of the centre lines / L", color=MUTED)
    gap.grid(axis="y")
    gap.legend()
    return to_svg(figure, "overlay", "Centre lines of beam and solid bent to 90 and 180 degrees")


def stress() -> Markup | None:
    """Axial Cauchy stress of the middle section of beam, solid and section problem, one colour scale."""
    scene = loaded(ARM, "bending", STRESS_ANGLE)
    exact = answer("solid", scene)
    if exact.reason:
        return None
    points, solid = _stress_of(exact)
    panels = {"solid, hex27": solid}
    for element, elements in (("3363", 16), ("3333", 16)):
        solution = solve(changed(scene, {"element": element, "elements": elements}))
        panels[f"beam {element}"] = _beam_stress(solution, points)
    modulus = RUBBER["young_modulus"]
    top = max(float(np.max(np.abs(values))) for values in panels.values()) / modulus
    figure = new_figure(9.2, 3.4)
    for axes, (name, values) in zip(figure.subplots(1, 3), panels.items(), strict=True):
        shown = axes.tricontourf(
            points[:, 1] * 1e3, points[:, 0] * 1e3, values / modulus, 21, cmap="RdBu_r", vmin=-top, vmax=top
        )
        worst = float(np.max(np.abs(values - solid))) / modulus
        note = "" if name.startswith("solid") else f"\nlargest difference {worst:.1e} E"
        axes.set_title(f"{name}{note}", color=INK)
        axes.set_aspect("equal")
        axes.set_xlabel("z, mm")
        figure.colorbar(shown, ax=axes, shrink=0.72, format="%.2f")
    figure.axes[0].set_ylabel("y, mm")
    return to_svg(figure, "stress", "Axial Cauchy stress of the middle section: solid, 3363, 3333")


def rates(results: Sequence[CaseResult]) -> Markup | None:
    """Distance of beam tips from the exact section problem against kappa R, with the slope of order 2."""
    found = [r for r in results if r.case.problem == "gap rate" and r.outcome is not None and r.outcome.rows]
    if not found:
        return None
    figure = new_figure(9.2, 4.2)
    axes = figure.add_subplot()
    for result in found:
        radii = np.array(result.case.parameters["radii"])
        length, angle = result.case.rod["length"], math.radians(result.case.parameters["sizes"][0])
        gaps = [row.found for row in result.outcome.rows[: len(radii)]]  # type: ignore[union-attr]
        place = result.case.place
        marker, colour = STYLES.get(place["element"], ("o", VIOLET))
        line = "-" if "0.3" in place["law"] else "--"
        axes.loglog(angle * radii / length, gaps, line, marker=marker, color=colour, lw=1.2,
                    label=f"{place['element']}, {place['law']}")  # fmt: skip
    low, high = axes.get_xlim()
    kappa = np.array([low, high]) * [1.1, 0.9]
    axes.loglog(kappa, 0.05 * kappa**2, color=FAINT, lw=3, zorder=0)
    axes.text(kappa[1], 0.05 * kappa[1] ** 2, " order 2", color=MUTED, va="center", fontsize=9)
    axes.set_xlabel("κR, surface strain of the thin rod")
    axes.set_ylabel("distance of the tip / L")
    axes.grid(which="both", axis="both")
    axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    return to_svg(figure, "rates", "Distance of the beam from the exact section problem against kappa R")


def _stress_of(exact: Answer) -> tuple[Floats, Floats]:
    stored = exact.values["stress"]
    return np.array(stored["points"]), np.array(stored["axial"])


def _beam_stress(solution: Any, points: Floats) -> Floats:
    """Cauchy stress along the section's normal in the middle of the rod (n,) [Pa]."""
    sigma = solution.section_stress(None, 0.5, points[:, 0], points[:, 1])
    normal = solution.pose(None, 0.5).rotation[:, 0]
    return np.einsum("i,nij,j->n", normal, sigma, normal)


__all__ = ["overlay", "rates", "stress"]
