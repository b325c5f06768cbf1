"""Three-dimensional pictures of one solution by pyvista: a PNG file, or the plotter for a page.

Needs the extra "pictures"; no display is used. The skin carries a field (view_skin.py), the reference shape
is a grey ghost, loads and supports are marks (view_marks.py).
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancf.view_marks import Mark, marks
from ancf.view_skin import FIELD, FIELDS, Field, Scale, box, ghosts, skins, telling_field

if TYPE_CHECKING:
    from ancf.solution import Solution

Floats = NDArray[np.float64]

WIDTH, NARROWEST, LOWEST, HIGHEST = 680, 400, 340, 620  # pixels
LEGEND = 88  # pixels below the scene
INK = "#1b2631"
GHOST, GHOST_OPACITY = "#9aa5ad", 0.22
CLEAR = 0.55  # opacity of rods with something inside
AMBIENT = 0.3  # of the light: shaded sides keep their colour
MARGIN = 1.08
VIEW_ANGLE = 30.0  # degrees, of the page; vtk.js knows no other
PAGE_ASPECT = 1.3  # width to height of the window, at least
PAGE_MARGIN = 1.25  # room for title and legend
TILT = (0.30, 0.42)  # how far the view leaves the normal of a plane scene: upwards, sideways


@dataclass(frozen=True)
class View:
    """A pyvista Plotter, off screen, with rods, ghost and marks; the first skin, what its colours mean."""

    plotter: Any
    skin: Any
    scale: Scale
    solution: Solution


def picture(
    solution: Solution,
    path: str | os.PathLike[str],
    field: str | None = None,
    direction: ArrayLike | None = None,
    up: ArrayLike | None = None,
    ghost: bool = True,
) -> None:
    """Write a PNG of a solution; the file appears whole or not at all.

    Parameters
    ----------
    field : of `FIELDS`; the more telling one if None
    direction : (3,) from the scene to the eye; for a plane scene oblique to its plane if None
    up : (3,) shown upwards; against gravity, else z or y, if None
    ghost : whether the reference shape is shown
    """
    from PIL import Image

    target = Path(path)
    view = view_of(solution, field, ghost)
    width, height = frame(view, direction, up)
    view.plotter.window_size = [width, height]
    _add_legend(view, width, height)
    pixels = view.plotter.screenshot(return_img=True, scale=2)  # drawn at twice the size, for smooth edges
    view.plotter.close()
    image = Image.fromarray(pixels).resize((width, height), Image.Resampling.LANCZOS)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".unfinished-") as stage:
        written = Path(stage) / target.name
        # A palette with error diffusion is as good to the eye, at half the size.
        palette = image.quantize(256, method=Image.Quantize.MAXCOVERAGE)
        image.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(written, optimize=True)
        os.replace(written, target)


def view_of(solution: Solution, field: str | None = None, ghost: bool = True) -> View:
    """Everything that is drawn of a solution, but camera and legend."""
    import pyvista

    chosen = telling_field(solution) if field is None else FIELDS[field]
    with pyvista.vtk_verbosity("off"):  # without a display VTK tries one all the same, and says so
        plotter: Any = pyvista.Plotter(off_screen=True, window_size=[WIDTH, LOWEST], lighting="light kit")
    plotter.set_background("white")
    found = marks(solution, float(np.linalg.norm(np.subtract(*box(solution)))))
    skin, scale = _add_rods(plotter, solution, chosen, found)
    for shape in ghosts(solution) if ghost else []:
        plotter.add_mesh(shape, color=GHOST, opacity=GHOST_OPACITY, smooth_shading=True)
    for mark in found:
        plotter.add_mesh(
            mark.mesh, color=mark.colour, opacity=mark.opacity, smooth_shading=True, split_sharp_edges=True,
            ambient=AMBIENT, specular=0.1,
        )  # fmt: skip
    return View(plotter, skin, scale, solution)


def _add_rods(plotter: Any, solution: Solution, field: Field, found: Sequence[Mark]) -> tuple[Any, Scale]:
    """Add all skins; the actor of the first skin, and what the colours mean."""
    drawn, scale = skins(solution, field)
    clear = any(mark.inside for mark in found)
    actors = [
        plotter.add_mesh(
            skin, scalars=FIELD, cmap=scale.colours, clim=(scale.low, scale.high), smooth_shading=True,
            specular=0.2, specular_power=25, ambient=AMBIENT, opacity=CLEAR if clear else 1.0,
            show_scalar_bar=False,
        )
        for skin in drawn
    ]  # fmt: skip
    return actors[0], scale


def frame(view: View, direction: ArrayLike | None = None, up: ArrayLike | None = None) -> tuple[int, int]:
    """Point the camera so that everything just fits above the legend; width and height [pixels] that suit."""
    axes, low, high = _extent(view, direction, up)
    wide, tall, deep = high - low
    height = int(np.clip(WIDTH * tall / wide + LEGEND, LOWEST, HIGHEST))
    drawn = MARGIN * max(tall * height / (height - LEGEND), wide * height / WIDTH)  # m from bottom to top
    middle = 0.5 * (low + high) - [0.0, 0.5 * drawn * LEGEND / height, 0.0]
    _point_camera(view, axes, middle, deep + drawn)
    view.plotter.camera.parallel_projection = True
    view.plotter.camera.parallel_scale = 0.5 * drawn
    return int(np.clip(MARGIN * wide * height / drawn, NARROWEST, WIDTH)), height


def aim(view: View, direction: ArrayLike | None = None, up: ArrayLike | None = None) -> None:
    """Point the camera of a page, which has perspective and whatever size its window has."""
    axes, low, high = _extent(view, direction, up)
    wide, tall, deep = high - low
    drawn = PAGE_MARGIN * max(tall, wide / PAGE_ASPECT)
    view.plotter.camera.view_angle = VIEW_ANGLE
    distance = 0.5 * drawn / np.tan(np.deg2rad(0.5 * VIEW_ANGLE)) + 0.5 * deep
    _point_camera(view, axes, 0.5 * (low + high), distance)


def _extent(view: View, direction: ArrayLike | None, up: ArrayLike | None) -> tuple[Floats, Floats, Floats]:
    """Axes of the view as rows: right, up, to the eye; lowest and highest coordinates (3,) of all meshes."""
    eye, upwards = _outlook(view.solution, direction, up)
    axes = np.array([np.cross(upwards, eye), upwards, eye])
    points = np.concatenate([mesh.points for mesh in view.plotter.meshes]) @ axes.T
    return axes, points.min(axis=0), points.max(axis=0)


def _point_camera(view: View, axes: Floats, middle: Floats, distance: float) -> None:
    """Look at a point, given by its coordinates along the axes of the view, from a distance."""
    camera = view.plotter.camera
    focus = middle @ axes
    camera.focal_point, camera.position, camera.up = focus, focus + distance * axes[2], axes[1]
    view.plotter.reset_camera_clipping_range()


def _outlook(solution: Solution, direction: ArrayLike | None, up: ArrayLike | None) -> tuple[Floats, Floats]:
    """Unit vectors to the eye and upwards, at right angles."""
    at = np.linspace(0.0, 1.0, 41)
    axes = [
        place(rod.name, at, np.zeros(1), np.zeros(1))
        for rod in solution.scene.rods
        for place in (solution.displaced, solution.reference)
    ]
    points = np.concatenate(axes)
    _, extent, main = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    normal = main[2] * (np.sign(main[2] @ [0.3, -1.0, 0.9]) or 1.0)  # from the front, from above
    if extent[1] < 1e-6 * extent[0]:  # one straight line, which has no plane
        normal = np.cross(main[0], [0.0, 0.0, 1.0] if abs(main[0][2]) < 0.9 else [1.0, 0.0, 0.0])
    above = np.eye(3)[1 if abs(normal[2]) > 0.8 * np.linalg.norm(normal) else 2]
    gravity = solution.scene.gravity
    if up is not None:
        above = np.asarray(up, float) / np.linalg.norm(up)
    elif gravity is not None and np.any(gravity.acceleration):
        above = -gravity.acceleration / np.linalg.norm(gravity.acceleration)
    eye = normal + TILT[0] * above + TILT[1] * np.cross(above, normal)
    eye = np.asarray(eye if direction is None else direction, float)
    eye = eye / np.linalg.norm(eye)
    upwards = above - (above @ eye) * eye
    return eye, upwards / np.linalg.norm(upwards)


def _add_legend(view: View, width: int, height: int) -> None:
    """A horizontal bar below the scene, its title above it."""
    bar = view.plotter.add_scalar_bar(
        title=view.scale.title + "\n", mapper=view.skin.mapper, vertical=False,
        width=286 / width, height=84 / height, position_x=0.5 - 143 / width, position_y=2 / height,
        n_labels=3, fmt="%.3g", color=INK, title_font_size=17, label_font_size=15, font_family="arial",
    )  # fmt: skip
    bar.SetBarRatio(0.22)  # of its box; the rest is room for the numbers and the title
