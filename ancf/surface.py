"""The skin of a rod: deformed outline rings with displacement, strain and stress, for files and pictures.

Strain and stress are evaluated at the axial integration points, where a reduced rule is accurate (between
them it is not), and continued linearly to the two ends.

Symbols
-------
E_gl    Green-Lagrange strain in the axes of the reference section (x along the axis, y, z)
S_pk2   second Piola-Kirchhoff stress in the same axes [Pa]
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.section_stress import cauchy_stress, part_skin, second_stress, section_strain, tensor

if TYPE_CHECKING:
    from ancf.rod_model import RodModel
    from ancf.solution import Solution

Floats = NDArray[np.float64]

OUTLINE_POINTS = 24  # around a round section; polygons have their corners
MOST_RINGS = 400  # finer rods are thinned out: a picture or a mesh file needs no more


@dataclass(frozen=True)
class Surface:
    """Rings of points around a part of a rod, from its base to its end."""

    at: Floats  # (rings,) fraction of the reference length
    position: Floats  # (rings, points, 3) m, deformed, SCS
    displacement: Floats  # (rings, points, 3) m, SCS
    strain: Floats  # (rings, points, 3, 3) E_gl
    stress: Floats  # (rings, points, 3, 3) S_pk2

    @property
    def quads(self) -> NDArray[np.intp]:
        """Corners (n, 4) of the facets between neighbouring rings, as indices of the flattened points."""
        rings, points = self.position.shape[:2]
        index = np.arange(rings * points).reshape(rings, points)
        following = np.roll(index, -1, axis=1)
        corners = [index[:-1], following[:-1], following[1:], index[1:]]
        return np.stack(corners, axis=-1).reshape(-1, 4)


def rod_surface(solution: Solution, name: str, part: int = 0) -> Surface:
    """Evaluate the skin of a part of a rod: strain and stress of its own law (section_stress.py).

    A plain rod is one part. The skins of parts with different sections do not meet; the step between them is
    left open.
    """
    rod = next(model for model in solution.model.rods if model.rod.name == name)
    y, z = part_skin(rod, part, OUTLINE_POINTS)
    chosen, at = _chosen_rings(rod, part)
    first, last = rod.rod.ends[part : part + 2]
    segment = rod.rod.parts[part]
    share = (at - first) / (last - first)
    rings = np.array([segment.section_at(float(s)).outline(OUTLINE_POINTS) for s in share])
    y_ring, z_ring = np.moveaxis(rings, -1, 0)
    position = solution.displaced(name, at[:, None], y_ring, z_ring)
    strain = section_strain(rod, solution.q, y, z, part)[chosen]
    stress = second_stress(rod, solution.q, y, z, part)[chosen]
    return Surface(
        at=at,
        position=position,
        displacement=position - solution.reference(name, at[:, None], y_ring, z_ring),
        strain=tensor(_to_ends(strain, at), shear=0.5),
        stress=tensor(_to_ends(stress, at), shear=1.0),
    )


def skin_stress(solution: Solution, name: str, part: int = 0) -> Floats:
    """Cauchy stress (rings, points, 3, 3) [Pa] in SCS at the points of `rod_surface`."""
    rod = next(model for model in solution.model.rods if model.rod.name == name)
    y, z = part_skin(rod, part, OUTLINE_POINTS)
    chosen, at = _chosen_rings(rod, part)
    return _to_ends(cauchy_stress(rod, solution.q, y, z, part)[chosen], at)


def _chosen_rings(rod: RodModel, part: int) -> tuple[NDArray[np.intp], Floats]:
    """Axial points of a part that carry rings, and the stations of all rings, the two ends among them."""
    x = rod.axial_abscissae[rod.elements_of(part)].ravel()
    chosen = np.unique(np.linspace(0, len(x) - 1, min(len(x), MOST_RINGS)).round().astype(int))
    first, last = rod.rod.ends[part : part + 2]
    return chosen, np.concatenate([[first], x[chosen] / rod.rod.length, [last]])


def _to_ends(values: Floats, at: Floats) -> Floats:
    """Continue values (rings, ...) linearly to the ring before the first and the one after the last."""
    if len(values) == 1:
        return np.concatenate([values, values, values])
    first = values[0] + (values[1] - values[0]) * (at[0] - at[1]) / (at[2] - at[1])
    last = values[-1] + (values[-1] - values[-2]) * (at[-1] - at[-2]) / (at[-2] - at[-3])
    return np.concatenate([first[None], values, last[None]])
