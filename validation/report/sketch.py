"""Small line drawings of solved rods: reference dashed, equilibrium solid, support hatched, "
"load as an arrow."""

from __future__ import annotations

import math

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from ancf.solution import Solution
from validation.report.style import BLUE, INK, MUTED, ORANGE

Floats = NDArray[np.float64]

WIDTH, HEIGHT, EDGE = 260.0, 170.0, 26.0  # px
STATIONS = 41


def projection(points: Floats) -> Floats:
    """Rows (2, 3) that map space to the drawing: a coordinate plane for plane shapes, isometric otherwise."""
    extent = np.ptp(points, axis=0)
    flat = extent < 0.02 * max(float(np.max(extent)), 1e-300)
    x, y, z = np.eye(3)
    if flat[2]:
        return np.array([x, y])
    if flat[1]:
        return np.array([x, z])
    if flat[0]:
        return np.array([y, z])
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    return np.array([c * x - c * y, -s * x * 0.6 - s * y * 0.6 + z])


def sketch(solution: Solution, label: str) -> Markup:
    """The first rod of a solution as SVG."""
    at = np.linspace(0.0, 1.0, STATIONS)
    base = solution.scene.rods[0].base.position
    now = solution.displaced(None, at, 0.0, 0.0) - base
    before = solution.reference(None, at, 0.0, 0.0) - base
    view = projection(np.concatenate([now, before]))
    a, b = before @ view.T, now @ view.T
    low = np.minimum(a.min(axis=0), b.min(axis=0))
    size = np.maximum(np.maximum(a.max(axis=0), b.max(axis=0)) - low, 1e-12)
    scale = min((WIDTH - 2 * EDGE) / size[0], (HEIGHT - 2 * EDGE) / size[1])
    shift = np.array([WIDTH, HEIGHT]) / 2 - scale * size / 2

    def place(points: Floats) -> Floats:
        q = (points - low) * scale + shift
        return np.column_stack([q[:, 0], HEIGHT - q[:, 1]])

    a, b = place(a), place(b)
    thick = float(np.clip(2 * solution.scene.rods[0].section.outer_radius * scale, 3.0, 16.0))
    nodes = place((solution.nodes(None) - base) @ view.T)
    parts = [
        _line(a, MUTED, 1.4, dash="5 4"),
        _line(b, "#bcd9ea", thick),
        _line(b, BLUE, 1.8),
        *(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="1.9" fill="#fff" stroke="{BLUE}" stroke-width="1"/>'
            for x, y in (nodes if len(nodes) <= 26 else nodes[:: len(nodes) // 12])
        ),
    ]
    parts += [
        _support(place(_point(solution, s.at) @ view.T - 0.0)[0], _tangent(a, s.at))
        for s in solution.scene.rods[0].supports
    ]
    parts += _loads(solution, view, place)
    return Markup(
        f'<svg xmlns="http://www.w3.org/2000/svg" class="sketch" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" '
        'role="img" '
        f'aria-label="{Markup.escape(label)}">{"".join(parts)}</svg>'
    )


def _point(solution: Solution, at: float) -> Floats:
    base = solution.scene.rods[0].base.position
    return (solution.pose(None, at).position - base)[None]


def _line(points: Floats, colour: str, width: float, dash: str = "") -> str:
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    dashes = f' stroke-dasharray="{dash}"' if dash else ""
    return (
        f'<polyline points="{text}" fill="none" stroke="{colour}" stroke-width="{width:.1f}" '
        f'stroke-linecap="round" stroke-linejoin="round"{dashes}/>'
    )


def _tangent(points: Floats, at: float) -> Floats:
    """Unit direction of the drawn reference at a fraction of its length; upright where it "
    "points at the reader."""
    index = min(int(at * (len(points) - 1)), len(points) - 2)
    step = points[index + 1] - points[index]
    length = float(np.linalg.norm(step))
    return step / length if length > 0.3 else np.array([1.0, 0.0])


def _support(place: Floats, tangent: Floats) -> str:
    """A wall across the rod with hatching behind it."""
    across = np.array([-tangent[1], tangent[0]])
    ends = [place - 13 * across, place + 13 * across]
    strokes = [_line(np.array(ends), INK, 2.0)]
    for k in range(6):
        foot = place + (-11 + 4.6 * k) * across
        strokes.append(_line(np.array([foot, foot - 6 * tangent + 4 * across]), INK, 0.9))
    return "".join(strokes)


def _loads(solution: Solution, view: Floats, place) -> list[str]:
    """Arrows of the point loads: one head for a force, two for a moment; a row of arrows for a line load."""
    scene, parts = solution.scene, []
    for load, heads in [(f, 1) for f in scene.forces] + [(m, 2) for m in scene.moments]:
        pose = solution.pose(load.rod, load.at)
        value = pose.rotation @ load.value if load.direction == "follower" else load.value
        foot = place((pose.position - scene.rods[0].base.position)[None] @ view.T)[0]
        parts.append(_arrow(foot, view @ value, float(np.linalg.norm(value)), heads))
    spread = [load.value for load in scene.line_loads]
    if scene.gravity is not None:
        spread.append(scene.gravity.acceleration)
    for value in spread:
        for at in (0.3, 0.5, 0.7, 0.9):
            pose = solution.pose(None, at)
            foot = place((pose.position - scene.rods[0].base.position)[None] @ view.T)[0]
            parts.append(_arrow(foot, view @ value, float(np.linalg.norm(value)), 1, 16.0))
    return parts


def _arrow(foot: Floats, drawn: Floats, size: float, heads: int, reach: float = 26.0) -> str:
    """An arrow from a point; a value along the line of sight is drawn as a dot in a circle."""
    if size == 0.0:
        return ""
    direction = np.array([drawn[0], -drawn[1]]) / size
    shown = float(np.linalg.norm(direction))
    if shown < 0.25:
        if heads == 2:  # a moment towards the reader: an arc around the point
            return (
                f'<path d="M {foot[0] + 11:.1f} {foot[1]:.1f} '
                f'A 11 11 0 1 0 {foot[0]:.1f} {foot[1] + 11:.1f}" '
                f'fill="none" stroke="{ORANGE}" stroke-width="2"/>'
                f'<path d="M {foot[0] - 5:.1f} {foot[1] + 7.5:.1f} l 7 3.6 l -6 4.6 z" fill="{ORANGE}"/>'
            )
        return (
            f'<circle cx="{foot[0]:.1f}" cy="{foot[1]:.1f}" r="6" '
            f'fill="#fff" stroke="{ORANGE}" stroke-width="2"/>'
            f'<circle cx="{foot[0]:.1f}" cy="{foot[1]:.1f}" r="2" fill="{ORANGE}"/>'
        )
    unit = direction / shown
    length = reach * max(shown, 0.55)
    # Keep the arrow inside the drawing: turn it into a pull from outside where it would leave.
    end = foot + length * unit
    across = np.array([-unit[1], unit[0]])
    parts = [_line(np.array([foot, end]), ORANGE, 2.0)]
    for k in range(heads):
        top = end - 6 * k * unit + 3 * unit
        corners = [top, top - 8 * unit + 3.6 * across, top - 8 * unit - 3.6 * across]
        parts.append(
            f'<polygon points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in corners)}" fill="{ORANGE}"/>'
        )
    return "".join(parts)
