"""Skins of rods as pyvista meshes, with a field on them: what the three-dimensional pictures draw of a rod.

Rings lie closer than the axial points, so that a bent rod is round; the field, which is known at the axial
points, is linear between them (surface.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancf.rotation import log
from ancf.surface import Surface, rod_surface, skin_stress

if TYPE_CHECKING:
    from ancf.scene import Rod
    from ancf.solution import Solution

Floats = NDArray[np.float64]

RINGS = 120  # along a rod at least, shared by its parts: smooth at the size of a page
OUTLINE_POINTS = 24  # as surface.py's, whose field is drawn
FIELD = "field"  # the name of the data; its title has a unit
THIN = 0.012  # of the size of the scene, a radius: both sides are not seen
SHARP_EDGE = 40.0  # degrees; between the facets of a circle there are 15


@dataclass(frozen=True)
class Field:
    """A quantity on the skin: how it comes of a solution, in which units, and whether zero is special."""

    name: str
    units: tuple[tuple[str, float], ...]  # from small to large, with their sizes; one is chosen
    colours: str  # a colour map of matplotlib
    signed: bool
    values: Callable[[Solution, str, int, Surface], Floats]  # (rings, points), SI


@dataclass(frozen=True)
class Scale:
    """What the colours mean: a title with the unit, the ends of the range, the colour map."""

    title: str
    low: float
    high: float
    colours: str


def _axial_strain(solution: Solution, name: str, part: int, surface: Surface) -> Floats:
    return surface.strain[..., 0, 0]


def _equivalent_stress(solution: Solution, name: str, part: int, surface: Surface) -> Floats:
    """Von Mises stress sqrt(3/2 s : s) with the deviator s of the Cauchy stress [Pa]."""
    stress = skin_stress(solution, name, part)
    deviator = stress - np.trace(stress, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) / 3.0
    return np.sqrt(1.5 * np.sum(deviator**2, axis=(-2, -1)))


def _curvature(solution: Solution, name: str, part: int, surface: Surface) -> Floats:
    """Bending curvature of a section's axes, |Log(A_i^T A_{i+1})_{y, z}| over the reference length [1/m].

    Taken between axial points, where section axes are accurate; linear between the middles.
    """
    rod = next(model for model in solution.model.rods if model.rod.name == name)
    here = rod.elements_of(part)
    x = rod.axial_abscissae[here].ravel()
    axes = solution.section_axes(name).reshape(-1, rod.axial_points, 3, 3)[here].reshape(-1, 3, 3)
    turns = log(np.swapaxes(axes[:-1], -1, -2) @ axes[1:])
    bending = np.linalg.norm(turns[:, 1:], axis=-1) / np.diff(x)
    middles = 0.5 * (x[:-1] + x[1:]) / rod.rod.length
    along = np.interp(surface.at, middles, bending)
    return np.broadcast_to(along[:, None], surface.strain.shape[:2])


FIELDS = {
    "axial strain": Field("axial strain", (("%", 1e-2),), "coolwarm", True, _axial_strain),
    "stress": Field(
        "von Mises stress",
        (("Pa", 1.0), ("kPa", 1e3), ("MPa", 1e6), ("GPa", 1e9)),
        "viridis",
        False,
        _equivalent_stress,
    ),
    "curvature": Field("curvature", (("1/m", 1.0),), "viridis", False, _curvature),
}


def telling_field(solution: Solution) -> Field:
    """Axial strain; stress where rods are mostly twisted; curvature where they are thin and bent.

    Strain cannot show twist, and on a thin rod its two sides are not seen.
    """
    strains = [rod_surface(solution, name, part).strain for name, _, part in parts(solution)]
    axial = max(float(np.abs(strain[..., 0, 0]).max()) for strain in strains)
    shear = max(float(np.abs(strain[..., 0, 1:]).max()) for strain in strains)
    if shear > axial:
        return FIELDS["stress"]
    low, high = box(solution)
    thickest = max(widest(rod, at) for rod in solution.scene.rods for at in (0.0, 1.0))
    return FIELDS["curvature" if thickest < THIN * np.linalg.norm(high - low) else "axial strain"]


def box(solution: Solution) -> tuple[Floats, Floats]:
    """Lowest and highest corner (3,) [m] of axes and skins, undeformed and deformed, roughly."""
    at = np.linspace(0.0, 1.0, 41)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for rod in solution.scene.rods:
        radius = max(widest(rod, 0.0), widest(rod, 1.0))
        for place in (solution.displaced, solution.reference):
            axis = place(rod.name, at, np.zeros(1), np.zeros(1))
            low = np.minimum(low, axis.min(axis=0) - radius)
            high = np.maximum(high, axis.max(axis=0) + radius)
    return low, high


def widest(rod: Rod, at: float) -> float:
    """Largest distance [m] of a section's outline from the axis."""
    return float(np.linalg.norm(rod.section_at(at).outline(OUTLINE_POINTS), axis=-1).max())


def parts(solution: Solution) -> Iterator[tuple[str, Rod, int]]:
    """Every part of every rod: name of the rod, the rod, number of the part."""
    for rod in solution.scene.rods:
        for part in range(len(rod.parts)):
            yield rod.name, rod, part


def skins(solution: Solution, field: Field) -> tuple[list[Any], Scale]:
    """Deformed skins (pyvista PolyData) of all parts, the field as point data FIELD, and its common scale."""
    drawn, found = [], []
    for name, rod, part in parts(solution):
        surface = rod_surface(solution, name, part)
        values = field.values(solution, name, part, surface)
        at = _stations(rod, part)
        found.append(np.array([np.interp(at, surface.at, column) for column in values.T]).T)
        drawn.append(_rings(solution, rod, part, at, deformed=True))
    largest = max(float(np.abs(values).max()) for values in found)
    unit, size = next((u for u in reversed(field.units) if u[1] <= largest), field.units[0])
    high = largest / size or 1.0
    scale = Scale(f"{field.name} [{unit}]", -high if field.signed else 0.0, high, field.colours)
    return [closed_skin(rings, v / size) for rings, v in zip(drawn, found, strict=True)], scale


def ghosts(solution: Solution) -> list[Any]:
    """Skins of the reference shape (pyvista PolyData)."""
    return [
        closed_skin(_rings(solution, rod, part, _stations(rod, part), deformed=False))
        for _, rod, part in parts(solution)
    ]


def _stations(rod: Rod, part: int) -> Floats:
    """Fractions of the rod's length at which rings are drawn: of its share of RINGS, or four an element."""
    first, last = rod.ends[part : part + 2]
    count = max(math.ceil(RINGS * (last - first)), 4 * rod.parts[part].elements, 2)
    return np.linspace(first, last, count + 1)


def _rings(solution: Solution, rod: Rod, part: int, at: Floats, deformed: bool) -> Floats:
    """Points (rings, points, 3) of the outlines at stations of a part."""
    first, last = rod.ends[part : part + 2]
    segment = rod.parts[part]
    outlines = np.array(
        [segment.section_at(float(s)).outline(OUTLINE_POINTS) for s in (at - first) / (last - first)]
    )
    y, z = np.moveaxis(outlines, -1, 0)
    place = solution.displaced if deformed else solution.reference
    return place(rod.name, at[:, None], y, z)


def closed_skin(points: Floats, values: Floats | None = None) -> Any:
    """Skin of rings (rings, points, 3) with both end faces, normals included."""
    import pyvista

    rings, count = points.shape[:2]
    index = np.arange(rings * count).reshape(rings, count)
    following = np.roll(index, -1, axis=1)
    quads = np.stack([index[:-1], following[:-1], following[1:], index[1:]], axis=-1).reshape(-1, 4)
    faces = [np.insert(quads, 0, 4, axis=1).ravel(), [count, *index[0, ::-1]], [count, *index[-1]]]
    mesh = pyvista.PolyData(points.reshape(-1, 3), np.concatenate(faces))
    if values is not None:
        mesh.point_data[FIELD] = values.ravel()
    return mesh.compute_normals(
        cell_normals=False, split_vertices=True, feature_angle=SHARP_EDGE, consistent_normals=False
    )
