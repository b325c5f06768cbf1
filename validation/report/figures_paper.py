"""The paper's figures 1 to 3, drawn from this program: element, four scenes, circular section."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

import ancf
from ancf.sections import Circle
from ancf.solution import Pose, Solution
from validation.problems import CaseResult
from validation.report.style import AXES, BLUE, INK, MUTED, ORANGE, new_figure, to_svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

# Seen from the front right, a little above: rows map (X, Y, Z) to the drawing plane.
VIEW = np.array([[0.80, -0.60, 0.0], [-0.21, -0.28, 0.94]])


def element() -> Markup:
    """Figure 1: one bent 3243 element with its eight nodal vectors, between BCS and SCS."""
    length, radius = 0.4, 0.022
    EI = 1e6 * np.pi * radius**4 / 4
    rod = {
        "length": length, "elements": 1, "element": "3243",
        "section": {"shape": "circle", "radius": radius},
        "material": {"young_modulus": 1e6, "poisson_ratio": 0.3},
        "base": {"position": [0.16, -0.05, 0.09], "x_axis": [1, -0.15, 0.25], "y_axis": [0.2, 1, 0]},
    }  # fmt: skip
    moment = (np.array([0.25, -0.75, 0.3]) * EI / length).tolist()
    solution = ancf.solve(ancf.scene_from_dict({"rod": [rod], "moment": [{"value": moment}]}))
    figure = new_figure(5.6, 3.4)
    axes = _canvas(figure.add_subplot())
    _tube(axes, solution, "#dcebf4", BLUE)
    origin = np.zeros(3)
    for direction, name in zip(np.eye(3), ("X", "Y", "Z"), strict=True):
        _vector(axes, origin, 0.07 * direction, INK, name)
    axes.annotate("SCS", _drawn(origin), xytext=(-8, -16), textcoords="offset points", fontsize=10, color=INK)
    for at, node in ((0.0, "1"), (1.0, "2")):
        pose = solution.pose(None, at)
        _frame(axes, pose, 0.085, names=True)
        start, end = _drawn(origin), _drawn(pose.position)
        axes.annotate(
            "", end, start, arrowprops={"arrowstyle": "->", "color": MUTED, "lw": 1.1, "ls": (0, (5, 3))}
        )
        share = 0.5 if node == "2" else 0.45
        axes.annotate(
            f"$r^{{{node}}}$", _drawn(share * pose.position), xytext=(4, -13),
            textcoords="offset points", color=MUTED,
            fontsize=11,
        )  # fmt: skip
        axes.plot(*end, "o", color=INK, ms=6, zorder=5)
        axes.annotate(
            f"node {node}", end, xytext=(-8, -30), textcoords="offset points", fontsize=10, color=INK
        )
    return to_svg(figure, "fig1", "One beam element with two nodes and the vectors r, r_x, r_y, r_z at each")


def scenes(results: Sequence[CaseResult]) -> Markup | None:
    """Figure 2: four scenes, undeformed and deformed with tip frames, base of eq. 3."""
    found = [r for r in results if r.case.row == "fig. 2" and r.outcome and r.outcome.solution]
    if not found:
        return None
    figure = new_figure(9.2, 3.1)
    panels = figure.subplots(1, len(found), squeeze=False)[0]
    names = "abcd"
    for k, (panel, result) in enumerate(zip(panels, found, strict=True)):
        assert result.outcome is not None and result.outcome.solution is not None
        axes, solution = _canvas(panel), result.outcome.solution
        _tube(axes, solution, "#eceff1", MUTED, reference=True)
        _tube(axes, solution, "#cfe4f1", BLUE)
        tip = solution.tip()
        rod = solution.scene.rods[0]
        before = Pose(
            rod.base.position + rod.length * rod.base.rotation[:, 0], *rod.base.rotation.T, rotation=np.eye(3)
        )
        _frame(axes, before, 0.055, alpha=0.45)
        _frame(axes, tip, 0.075, names=k == 0)
        _wall(axes)
        axes.set_xlim(-0.27, 0.27)
        axes.set_ylim(-0.05, 0.50)
        axes.set_title(f"({names[k]})  {_load_text(solution)}", fontsize=10, loc="left")
    return to_svg(
        figure, "fig2", "Four load cases of an arm along Z: undeformed and deformed, with tip frames"
    )


def section() -> Markup:
    """Figure 3: circular section in cylindrical coordinates, with the exact quadrature points."""
    figure = new_figure(3.6, 3.3)
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.axis("off")
    angle = np.linspace(0, 2 * np.pi, 200)
    axes.fill(np.cos(angle), np.sin(angle), color="#e8f1f7")
    axes.plot(np.cos(angle), np.sin(angle), color=BLUE)
    y, z, _ = Circle(1.0).quadrature(4)
    axes.plot(y, z, "o", color=BLUE, ms=4.5, alpha=0.85)
    for direction, name in (((1.35, 0), "y"), ((0, 1.35), "z")):
        axes.annotate("", direction, (0, 0), arrowprops={"arrowstyle": "->", "color": INK, "lw": 1.2})
        axes.annotate(name, direction, xytext=(5, 3), textcoords="offset points", fontsize=12)
    theta, r = 0.9, 0.82
    point = (r * np.cos(theta), r * np.sin(theta))
    axes.plot([0, point[0]], [0, point[1]], color=ORANGE, lw=1.6)
    axes.plot(*point, "o", color=ORANGE, ms=7)
    axes.annotate(
        "r",
        (point[0] / 2, point[1] / 2),
        xytext=(-12, 2),
        textcoords="offset points",
        color=ORANGE,
        fontsize=12,
    )
    arc = np.linspace(0, theta, 30)
    axes.plot(0.35 * np.cos(arc), 0.35 * np.sin(arc), color=ORANGE, lw=1.2)
    axes.annotate(
        "θ", (0.42 * np.cos(theta / 2), 0.42 * np.sin(theta / 2)), color=ORANGE, fontsize=12, va="center"
    )
    axes.annotate("R", (np.cos(-0.7), np.sin(-0.7)), xytext=(6, -10), textcoords="offset points", fontsize=12)
    axes.set_xlim(-1.1, 1.6)
    axes.set_ylim(-1.15, 1.5)
    return to_svg(figure, "fig3", "A circular section with radius, angle and quadrature points")


def _drawn(point: Floats) -> tuple[float, float]:
    """A point of space in the drawing."""
    x, y = VIEW @ point
    return float(x), float(y)


def _canvas(axes: Any) -> Axes:
    axes.set_aspect("equal")
    axes.axis("off")
    return axes


def _tube(axes: Axes, solution: Solution, fill: str, edge: str, reference: bool = False) -> None:
    """The rod's surface: the outline of its silhouette is the envelope of its section ellipses."""
    from matplotlib.collections import PolyCollection

    radius = solution.scene.rods[0].section.outer_radius
    place = solution.reference if reference else solution.displaced
    at = np.linspace(0.0, 1.0, 41)
    angle = 2 * np.pi * np.arange(20) / 20
    y, z = radius * np.cos(angle), radius * np.sin(angle)
    rings = place(None, at[:, None], y[None], z[None]) @ VIEW.T
    pieces = [_hull(np.concatenate(pair)) for pair in pairwise(rings)]
    axes.add_collection(PolyCollection(pieces, facecolors=fill, edgecolors=fill, linewidths=0.6))
    axis = place(None, at, 0.0, 0.0) @ VIEW.T
    axes.plot(axis[:, 0], axis[:, 1], color=edge, lw=1.3, ls=(0, (5, 3)) if reference else "-")
    for ring in (rings[0], rings[-1]):
        closed = np.vstack([ring, ring[:1]])
        axes.plot(closed[:, 0], closed[:, 1], color=edge, lw=0.9)


def _hull(points: Floats) -> Floats:
    from scipy.spatial import ConvexHull

    return points[ConvexHull(points, qhull_options="QJ").vertices]


def _frame(axes: Axes, pose: Pose, size: float, names: bool = False, alpha: float = 1.0) -> None:
    for name in ("r_x", "r_y", "r_z"):
        text = f"${name}$" if names else ""
        _vector(axes, pose.position, size * getattr(pose, name), AXES[name], text, alpha)


def _vector(axes: Axes, start: Floats, value: Floats, colour: str, text: str, alpha: float = 1.0) -> None:
    a, b = _drawn(start), _drawn(start + value)
    arrow = {"arrowstyle": "-|>", "color": colour, "lw": 1.8, "alpha": alpha, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", b, a, arrowprops=arrow, zorder=6)
    if text:
        step = np.subtract(b, a)
        x, y = 8 * step / max(float(np.linalg.norm(step)), 1e-9)
        axes.annotate(
            text,
            b,
            xytext=(x, y),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=10,
            color=colour,
        )
    axes.update_datalim([a, b])
    axes.autoscale_view()


def _wall(axes: Axes) -> None:
    """The clamp: a plate across Z at the base."""
    size = 0.05
    corners = size * np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
    drawn = corners @ VIEW.T
    axes.fill(drawn[:, 0], drawn[:, 1], color="#d5dbe0", ec=INK, lw=0.8, zorder=0)


def _load_text(solution: Solution) -> str:
    A_o = solution.scene.rods[0].base.rotation
    for load, unit, name in [(f, "N", "force") for f in solution.scene.forces] + [
        (m, "N m", "moment") for m in solution.scene.moments
    ]:
        local = A_o.T @ load.value
        axis = int(np.argmax(np.abs(local)))
        word = "along" if name == "force" else "about"
        return f"{name} {word} local {'xyz'[axis]}\n      {local[axis]:g} {unit}"
    return ""
