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

from ancf.surface import Surface, rod_surface, skin_stress

if TYPE_CHECKING:
    from ancf.scene import Rod
    from ancf.solution import Solution

Floats = NDArray[np.float64]

RINGS = 120  # along a rod at least, shared by its parts: smooth at the size of a page
OUTLINE_POINTS = 24  # as surface.py's, whose field is drawn
SHARP_EDGE = 40.0  # degrees; between the facets of a circle there are 15


@dataclass(frozen=True)
class Field:
    """A quantity on the skin: its name with the unit, how it comes of a solution, whether zero is special."""

    title: str
    colours: str  # a colour map of matplotlib
    signed: bool
    values: Callable[[Solution, str, int, Surface], Floats]  # (rings, points)

    def limits(self, values: list[Floats]) -> tuple[float, float]:
        """Range of the colours: symmetric about zero for a signed field, from zero for another."""
        largest = max(float(np.abs(v).max()) for v in values) or 1.0
        return (-largest, largest) if self.signed else (0.0, largest)


def _axial_strain(solution: Solution, name: str, part: int, surface: Surface) -> Floats:
    return 100.0 * surface.strain[..., 0, 0]


def _equivalent_stress(solution: Solution, name: str, part: int, surface: Surface) -> Floats:
    """Von Mises stress sqrt(3/2 s : s) with the deviator s of the Cauchy stress [kPa]."""
    stress = skin_stress(solution, name, part)
    deviator = stress - np.trace(stress, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) / 3.0
    return 1e-3 * np.sqrt(1.5 * np.sum(deviator**2, axis=(-2, -1)))


FIELDS = {
    "axial strain": Field("axial strain [%]", "coolwarm", True, _axial_strain),
    "stress": Field("von Mises stress [kPa]", "viridis", False, _equivalent_stress),
}


def telling_field(solution: Solution) -> Field:
    """Axial strain where rods stretch or bend; stress where they are mostly twisted, which it cannot show."""
    strains = [rod_surface(solution, name, part).strain for name, _, part in parts(solution)]
    axial = max(float(np.abs(strain[..., 0, 0]).max()) for strain in strains)
    shear = max(float(np.abs(strain[..., 0, 1:]).max()) for strain in strains)
    return FIELDS["axial strain" if axial >= shear else "stress"]


def parts(solution: Solution) -> Iterator[tuple[str, Rod, int]]:
    """Every part of every rod: name of the rod, the rod, number of the part."""
    for rod in solution.scene.rods:
        for part in range(len(rod.parts)):
            yield rod.name, rod, part


def skins(solution: Solution, field: Field) -> tuple[list[Any], tuple[float, float]]:
    """Deformed skins (pyvista PolyData) of all parts with the field as point data, and its common range."""
    drawn, found = [], []
    for name, rod, part in parts(solution):
        surface = rod_surface(solution, name, part)
        values = field.values(solution, name, part, surface)
        at = _stations(rod, part)
        found.append(np.array([np.interp(at, surface.at, column) for column in values.T]).T)
        drawn.append(closed_skin(_rings(solution, rod, part, at, deformed=True), found[-1], field.title))
    return drawn, field.limits(found)


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


def closed_skin(points: Floats, values: Floats | None = None, title: str = "") -> Any:
    """Skin of rings (rings, points, 3) with both end faces, normals included."""
    import pyvista

    rings, count = points.shape[:2]
    index = np.arange(rings * count).reshape(rings, count)
    following = np.roll(index, -1, axis=1)
    quads = np.stack([index[:-1], following[:-1], following[1:], index[1:]], axis=-1).reshape(-1, 4)
    faces = [np.insert(quads, 0, 4, axis=1).ravel(), [count, *index[0, ::-1]], [count, *index[-1]]]
    mesh = pyvista.PolyData(points.reshape(-1, 3), np.concatenate(faces))
    if values is not None:
        mesh.point_data[title] = values.ravel()
    return mesh.compute_normals(
        cell_normals=False, split_vertices=True, feature_angle=SHARP_EDGE, consistent_normals=False
    )
