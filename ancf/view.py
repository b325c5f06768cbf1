"""Pictures of solutions: the rods undeformed and deformed, with section rings and frames (paper fig. 2)."""

from __future__ import annotations

import math
import os
import tempfile
import textwrap
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancf.errors import InputError, Message
from ancf.mesh import reference_axis
from ancf.solution import Status

if TYPE_CHECKING:
    from ancf.scene import Rod
    from ancf.solution import Solution

Floats = NDArray[np.float64]

PICTURE_KINDS = (".png", ".svg", ".pdf")
PANEL_INCHES = 4.6
TUBE_RINGS = 60  # along a rod; smooth at the size of a panel
LEAST_RINGS = 2  # along a segment
OUTLINE_POINTS = 20
FRAME_SHARE = 0.14  # arrow length, of the rod's length
LEAST_SPAN = 0.4  # of the longest side of the box
AXIS_COLOURS = ("#c0392b", "#1e8449", "#1f4e9c")  # x, y, z
REFERENCE_COLOUR, DEFORMED_COLOUR = "#9aa5ad", "#d98e32"


def check_picture_path(path: str | os.PathLike[str]) -> Path:
    """Refuse, before anything is computed, a picture that could not be written (`InputError`)."""
    target = Path(path)
    problem: tuple[str, str, str] | None = None
    if target.suffix.lower() not in PICTURE_KINDS:
        kinds = ", ".join(PICTURE_KINDS)
        problem = (
            f"the ending {target.suffix or '(none)'} is none of {kinds}",
            "the ending names the format",
            kinds,
        )
    elif target.is_dir():
        problem = ("it is a directory", "the name is taken by a folder", "another name")
    elif not target.parent.is_dir():
        problem = (f"{target.parent} is no folder", "a misspelt path", "an existing folder")
    elif not os.access(target.parent, os.W_OK):
        problem = (f"{target.parent} may not be written", "missing permission", "another folder")
    elif find_spec("matplotlib") is None:
        problem = ("matplotlib is not installed", "it is an extra", "after pip install 'ancf[pictures]'")
    if problem is not None:
        value, cause, advice = problem
        raise InputError(
            Message("The picture cannot be drawn.", f"--plot {target}", value, cause, f"try {advice}")
        )
    return target


def draw(solutions: Sequence[Solution], path: str | os.PathLike[str]) -> None:
    """Draw one panel for each solution into a picture file (.png, .svg or .pdf).

    The file appears whole or not at all. Needs matplotlib (extra "pictures"); no display is used.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    target = check_picture_path(path)
    columns = math.ceil(math.sqrt(len(solutions)))
    rows = math.ceil(len(solutions) / columns)
    figure = Figure(figsize=(PANEL_INCHES * columns, PANEL_INCHES * rows), layout="constrained")
    FigureCanvasAgg(figure)
    for index, solution in enumerate(solutions):
        _draw_panel(figure.add_subplot(rows, columns, index + 1, projection="3d"), solution)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".unfinished-") as stage:
        written = Path(stage) / target.name
        figure.savefig(written, dpi=150)
        os.replace(written, target)


def _draw_panel(axes: Any, solution: Solution) -> None:
    """Draw all rods of one solution with equal scales on the three axes."""
    points = []
    for rod in solution.scene.rods:
        for part in range(len(rod.parts)):
            points += _draw_part(axes, solution, rod, part)
        end, frames = reference_axis(np.array([0.0, rod.length]), rod.curvature)
        A_o, size = rod.base.rotation, FRAME_SHARE * rod.length
        for position, frame in zip(end @ A_o.T + rod.base.position, A_o @ frames, strict=True):
            _draw_frame(axes, position, frame, size, alpha=0.45)
        tip = solution.tip(rod.name)
        _draw_frame(axes, tip.position, np.column_stack([tip.r_x, tip.r_y, tip.r_z]), size, alpha=1.0)
        points.append(tip.position + size * np.eye(3))
    _set_equal_scales(axes, np.concatenate(points))
    title = textwrap.fill(solution.scene.title, 48)
    if solution.status is not Status.CONVERGED:
        title += f"\n{solution.status} at load factor {solution.load_factor:.3g}"
    axes.set_title(title, fontsize=9, parse_math=False)


def _draw_part(axes: Any, solution: Solution, rod: Rod, part: int) -> list[Floats]:
    """Draw a part of a rod undeformed and deformed; return the points drawn."""
    segment, (first, last) = rod.parts[part], rod.ends[part : part + 2]
    share = np.linspace(0.0, 1.0, max(math.ceil(TUBE_RINGS * (last - first)), LEAST_RINGS) + 1)
    outlines = np.array([segment.section_at(float(s)).outline(OUTLINE_POINTS) for s in share])
    y, z = np.moveaxis(np.concatenate([outlines, outlines[:, :1]], axis=1), -1, 0)  # closed
    at = (first + (last - first) * share)[:, None]
    before = solution.reference(rod.name, at, y, z)
    after = solution.displaced(rod.name, at, y, z)
    rings = len(share) - 1
    marks = np.linspace(0, rings, min(segment.elements, rings) + 1).round().astype(int)
    _draw_tube(axes, before, marks, REFERENCE_COLOUR, alpha=0.25)
    _draw_tube(axes, after, marks, DEFORMED_COLOUR, alpha=0.85)
    return [before.reshape(-1, 3), after.reshape(-1, 3)]


def _set_equal_scales(axes: Any, points: Floats) -> None:
    """Show all points (n, 3) with the same scale on the three axes, which a thin rod must not flatten."""
    from matplotlib.ticker import MaxNLocator

    low, high = points.min(axis=0), points.max(axis=0)
    longest = float(np.max(high - low))
    span = np.maximum(high - low, LEAST_SPAN * longest)
    for name, middle, length in zip("xyz", 0.5 * (low + high), span, strict=True):
        getattr(axes, f"set_{name}lim")(middle - 0.5 * length, middle + 0.5 * length)
        getattr(axes, f"set_{name}label")(f"{name.upper()} [m]", fontsize=8)
        getattr(axes, f"{name}axis").set_major_locator(MaxNLocator(max(2, round(5 * length / longest))))
    axes.set_box_aspect(span, zoom=0.8)
    axes.tick_params(labelsize=6)


def _draw_tube(axes: Any, points: Floats, marks: NDArray[np.intp], colour: str, alpha: float) -> None:
    """Draw a skin (rings, points, 3), and the rings on the element boundaries as lines."""
    axes.plot_surface(
        *np.moveaxis(points, -1, 0), color=colour, alpha=alpha, linewidth=0, rstride=1, cstride=1, shade=True
    )
    for ring in points[marks]:
        axes.plot(*ring.T, color="black", alpha=0.6 * alpha, linewidth=0.5)


def _draw_frame(axes: Any, position: Floats, frame: Floats, size: float, alpha: float) -> None:
    """Draw the columns of a frame (3, 3) as arrows: x red, y green, z blue."""
    for axis, colour in zip(frame.T, AXIS_COLOURS, strict=True):
        axes.quiver(
            *position, *(size * axis), color=colour, alpha=alpha, linewidth=1.4, arrow_length_ratio=0.25
        )
