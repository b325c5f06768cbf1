"""Reading of a rod's cross-section; polygons are checked to be simple and counter-clockwise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.scene_table import REQUIRED, SIGNED, SIZE, Table
from ancf.sections import Annulus, Circle, Ellipse, Polygon, Rectangle, Section
from ancf.units import LENGTH

Floats = NDArray[np.float64]

SECTION_KEYS = {
    "circle": ("radius",),
    "annulus": ("radius", "inner_radius"),
    "rectangle": ("height_y", "width_z"),
    "ellipse": ("semi_axis_y", "semi_axis_z"),
    "polygon": ("points",),
}
THINNEST = 1e-6  # below it half of the digits of the section's moments are lost
MOST_CORNERS = 1000  # the test for crossing edges compares every pair


def read_section(table: Table) -> Section:
    """Read the cross-section; each shape knows its own keys."""
    shape = table.word("shape", tuple(SECTION_KEYS))
    table.expect_keys(("shape", *SECTION_KEYS[shape]))
    section = _polygon(table) if shape == "polygon" else _plain_shape(table, shape)
    thin = thinness(section)
    if not thin >= THINNEST:
        table.refuse(
            "",
            "The section is too thin to compute with.",
            f"radius of gyration / outer radius = {thin:.3g}, must be >= {THINNEST:g}",
            "one side is given in the wrong unit",
            "check the two sides of the section [m]",
        )
    return section


def thinness(section: Section) -> float:
    """Gyration radius of the weaker axis against the outer radius; squares of it divide in the solver."""
    return float(np.sqrt(np.linalg.eigvalsh(section.second_moments)[0] / section.area)) / section.outer_radius


def _plain_shape(table: Table, shape: str) -> Section:
    """Read a shape that is given by its sizes."""
    sizes = {key: table.number(key, LENGTH, limit=SIZE) for key in SECTION_KEYS[shape]}
    if shape == "annulus" and sizes["inner_radius"] > (1.0 - THINNEST) * sizes["radius"]:
        table.refuse(
            "inner_radius",
            "The annulus has no wall.",
            f"inner_radius = {sizes['inner_radius']:g} m, radius = {sizes['radius']:g} m",
            "the two radii are swapped, or diameters and radii are mixed",
            "give inner_radius < radius",
        )
    shapes = {"circle": Circle, "annulus": Annulus, "rectangle": Rectangle, "ellipse": Ellipse}
    return shapes[shape](**sizes)


def _polygon(table: Table) -> Polygon:
    """Read a polygon: at least three corners, simple, counter-clockwise, with an area."""
    corners = table.items("points", REQUIRED, "a list of [y, z] pairs")
    expected = f"3 to {MOST_CORNERS} corners [y, z]"
    if not 3 <= len(corners) <= MOST_CORNERS:
        table.refuse(
            "points",
            f"The polygon has {len(corners)} corners.",
            f"{len(corners)} given; {expected} are needed",
            "too few enclose no area, and more than a section needs cost time",
            f"give {expected}",
        )
    rows = Table({f"points[{i}]": corner for i, corner in enumerate(corners)}, table.source, table.path)
    points = np.array([rows.vector(key, 2, LENGTH, limit=SIGNED) for key in rows.data])
    scaled = points - points[0]
    size = float(np.max(np.abs(scaled)))
    following = np.roll(scaled, -1, axis=0)
    area = 0.5 * float(np.sum(scaled[:, 0] * following[:, 1] - following[:, 0] * scaled[:, 1]))
    advice = "list the corners once around, counter-clockwise seen with y to the right and z up"
    if size < 1e-20 or abs(area) < 1e-12 * size**2:
        table.refuse(
            "points",
            "The polygon has no area.",
            f"area = {area:.3g} m2",
            "all corners lie on one line",
            advice,
        )
    crossing = crossing_edges(scaled / size)
    if crossing:
        first, second = crossing
        table.refuse(
            "points",
            "The polygon crosses or touches itself.",
            f"the edges after points[{first}] and points[{second}] meet",
            "corners in a wrong order, or the first corner repeated at the end",
            advice,
        )
    if area < 0.0:
        table.refuse(
            "points",
            "The polygon runs clockwise.",
            f"signed area = {area:.3g} m2, must be > 0",
            "the corners are listed the wrong way round",
            "reverse the list: " + advice,
        )
    return Polygon(tuple((float(y), float(z)) for y, z in points))


def crossing_edges(points: Floats) -> tuple[int, int] | None:
    """Return two edges that meet elsewhere than in a shared corner, or None for a simple polygon.

    Only edges without a shared corner are compared: where an edge runs back over its neighbour, its end,
    and with it the next edge, touches that neighbour as well.
    """
    n = len(points)
    ends = np.roll(points, -1, axis=0)
    for i in range(n):
        if np.array_equal(points[i], ends[i]):
            return i, (i + 1) % n
        others = np.arange(i + 2, n - (i == 0))
        if len(others) == 0:
            continue
        a, b, c, d = points[i], ends[i], points[others], ends[others]
        side_c, side_d = _cross(b - a, c - a), _cross(b - a, d - a)
        side_a, side_b = _cross(d - c, a - c), _cross(d - c, b - c)
        boxes = np.all(
            (np.minimum(c, d) <= np.maximum(a, b)) & (np.minimum(a, b) <= np.maximum(c, d)), axis=1
        )
        meets = boxes & (side_c * side_d <= 0.0) & (side_a * side_b <= 0.0)
        if meets.any():
            return i, int(others[np.argmax(meets)])
    return None


def _cross(u: Floats, v: Floats) -> Floats:
    """z-component of u x v for plane vectors (..., 2)."""
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
