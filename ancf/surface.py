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

from ancf.materials import VOIGT
from ancf.section_energy import local_gradient, strain_matrix

if TYPE_CHECKING:
    from ancf.rod_model import RodModel
    from ancf.solution import Solution

Floats = NDArray[np.float64]

OUTLINE_POINTS = 24  # around a round section; polygons have their corners
MOST_RINGS = 400  # finer rods are thinned out: a picture or a mesh file needs no more


@dataclass(frozen=True)
class Surface:
    """Rings of points around a rod, from its base to its end."""

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


def rod_surface(solution: Solution, name: str) -> Surface:
    """Evaluate the skin of a rod.

    S_pk2 = D E_gl for the continuum; D_0 E_gl + D_v E_gl(axis) for the enhanced formulation, whose energy has
    the Poisson part D_v on the axis only.
    """
    rod = next(model for model in solution.model.rods if model.rod.name == name)
    outline = rod.rod.section.outline(OUTLINE_POINTS)
    x = rod.axial_abscissae.ravel()
    chosen = np.unique(np.linspace(0, len(x) - 1, min(len(x), MOST_RINGS)).round().astype(int))
    strain, stress = _strain_and_stress(solution, rod, outline, chosen)
    at = np.concatenate([[0.0], x[chosen] / rod.rod.length, [1.0]])
    y, z = outline.T
    position = solution.displaced(name, at[:, None], y, z)
    return Surface(
        at=at,
        position=position,
        displacement=position - solution.reference(name, at[:, None], y, z),
        strain=_tensor(_to_ends(strain, at), shear=0.5),
        stress=_tensor(_to_ends(stress, at), shear=1.0),
    )


def _strain_and_stress(
    solution: Solution, rod: RodModel, outline: Floats, chosen: NDArray[np.intp]
) -> tuple[Floats, Floats]:
    """E_gl and S_pk2 (chosen, points, 6), Voigt order, at some of the axial points; the axis comes last."""
    products = rod.elastic.gamma(rod.generalised(solution.q))
    products = products.reshape(-1, products.shape[-1])[chosen]
    v0 = np.broadcast_to(rod.elastic.v0, (*rod.axial_abscissae.shape, *rod.elastic.v0.shape[2:]))
    v0 = v0.reshape(-1, *v0.shape[2:])[chosen]
    y, z = np.concatenate([outline, [[0.0, 0.0]]]).T
    strain = np.empty((len(chosen), len(y), 6))
    for i, reference in enumerate(v0):
        _, weights = local_gradient(rod.element, reference, y, z)
        strain[i] = strain_matrix(weights) @ products[i]
    skin, axis = strain[:, :-1], strain[:, -1:]
    material = rod.rod.material
    if rod.rod.formulation == "continuum":
        return skin, skin @ material.hooke()
    D_0, D_v = material.enhanced(rod.rod.shear_factors)
    return skin, skin @ D_0 + axis @ D_v


def _to_ends(values: Floats, at: Floats) -> Floats:
    """Continue values (rings, ...) linearly to the ring before the first and the one after the last."""
    if len(values) == 1:
        return np.concatenate([values, values, values])
    first = values[0] + (values[1] - values[0]) * (at[0] - at[1]) / (at[2] - at[1])
    last = values[-1] + (values[-1] - values[-2]) * (at[-1] - at[-2]) / (at[-2] - at[-3])
    return np.concatenate([first[None], values, last[None]])


def _tensor(voigt: Floats, shear: float) -> Floats:
    """Symmetric tensors (..., 3, 3) from 6-vectors; strains carry a factor 2 in shear (materials.py)."""
    tensor = np.empty((*voigt.shape[:-1], 3, 3))
    for row, (a, b) in enumerate(VOIGT):
        tensor[..., a, b] = tensor[..., b, a] = voigt[..., row] * (1.0 if a == b else shear)
    return tensor
