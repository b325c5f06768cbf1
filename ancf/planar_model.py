r"""A model whose scene is its own mirror image in a plane, solved on the unknowns in the plane alone.

Coordinates, loads and residuals are those of the full model. Tangents and linear systems live on the planar
unknowns u (mirror_unknowns.py): with q = F u the tangent is F^T K F, in a narrower band.

At a shape in the plane the full tangent has two blocks, one on the planar unknowns and one on the motions
out of the plane. An equilibrium is a minimum if both are positive definite: the second is looked at wherever
Newton has converged. Where it is not, a branch out of the plane has turned off, which only the full model can
follow: `LeavesPlane`.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.band import Factors, SingularMatrixError
from ancf.effect_assembly import EffectAssembly
from ancf.mirror_system import Parity, PlanarSystem
from ancf.model import Model
from ancf.planar_energy import PlanarEnergy
from ancf.residual import Residual
from ancf.rod_model import RodModel
from ancf.scene_plane import Plane
from ancf.section_law import QuadratureSection

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


class LeavesPlane(Exception):
    """An equilibrium in the plane gives way to motions out of it."""


class PlanarModel(Model):
    """The model on its planar unknowns.

    Parameters
    ----------
    model : the full model, whose arrays are shared
    plane : a plane in which its scene is its own mirror image
    symmetric : whether its tangents on the planar unknowns are symmetric
    stays : whether an equilibrium in the plane is wanted even where it gives way to motions out of it
    """

    def __init__(self, model: Model, plane: Plane, symmetric: bool, stays: bool = False) -> None:
        _ = (model.unit, model.force_unit, model.q0)  # made once, shared
        vars(self).update(vars(model))
        self.plane = plane
        self.in_plane = Parity(model, plane, False, symmetric)
        self.across = Parity(model, plane, True, model.conservative)
        self.stays = stays
        self.eased = True
        self._elastic = [
            PlanarEnergy(even, odd) for even, odd in zip(self.in_plane.rods, self.across.rods, strict=True)
        ]
        vars(self)["system"] = PlanarSystem(model.system, self.in_plane)
        vars(self)["pattern"] = self.in_plane.pattern

    @property
    def solved(self) -> int:
        """Number of unknowns that the plane and the supports leave."""
        return self.in_plane.unknowns

    def admissible(self, q: Floats) -> Floats:
        """See `Model.admissible`; moved into the plane."""
        return super().admissible(self.in_plane.to_full(self.in_plane.of(q)))

    def is_planar(self, q: Floats, tolerance: float) -> bool:
        """Whether coordinates q (n,) are in the plane, dimensionless."""
        return self.largest_motion(q - self.in_plane.to_full(self.in_plane.of(q))) <= tolerance

    @cached_property
    def _laws_of_volume(self) -> list[tuple[RodModel, QuadratureSection]]:
        """See `Model._laws_of_volume`; on half of the section points."""
        laws = [(rod, elastic.section) for rod, elastic in zip(self.rods, self._elastic, strict=True)]
        return [(rod, law) for rod, law in laws if isinstance(law, QuadratureSection)]

    def residual_and_tangent(
        self, q: Floats, load_factor: float, q_previous: Floats | None = None
    ) -> tuple[Residual, Floats]:
        """See `Model.residual_and_tangent`; the tangent in the band of the planar unknowns."""
        side = self.in_plane
        flat, forces = np.zeros(side.pattern.entries), []
        u, u_previous = side.of(q), None if q_previous is None else side.of(q_previous)
        with self.counters.effect("elastic"):
            for rod, elastic in zip(side.rods, self._elastic, strict=True):
                before = None if u_previous is None else rod.of_elements(u_previous)
                Q, K = elastic.force_and_tangent(rod.of_elements(u), before)
                forces.append(Q)
                side.add_tangents(flat, rod, K)
            Q_int, Q_ext = side.element_forces_to_full(forces), np.zeros(self.n)
        self._sums_on_sides[0].terms(Q_int, Q_ext, flat, q, load_factor)
        return Residual(Q_int, Q_ext), flat

    @cached_property
    def _sums_on_sides(self) -> list[EffectAssembly]:
        """The effects, with their tangents in the plane and across it."""
        sides = (self.in_plane, self.across)
        return [
            EffectAssembly(self.effects, side.pattern, self.unit, False, self.counters, side)
            for side in sides
        ]

    def across_tangent(self, q: Floats, load_factor: float) -> Floats:
        """Tangent of the motions out of the plane at q (n,), in their flat band storage."""
        side = self.across
        flat = np.zeros(side.pattern.entries)
        u = self.in_plane.of(q)
        with self.counters.effect("elastic"):
            for rod, even, elastic in zip(side.rods, self.in_plane.rods, self._elastic, strict=True):
                side.add_tangents(flat, rod, elastic.odd_tangent(even.of_elements(u)))
        self._sums_on_sides[1].terms(np.zeros(self.n), np.zeros(self.n), flat, q, load_factor)
        return flat

    def is_minimum(self, q: Floats, load_factor: float, factors: Factors, flat: Floats) -> bool:
        """See `Model.is_minimum`; raises `LeavesPlane` where motions out of the plane release energy."""
        if not self.across.system.is_positive_definite(self.across_tangent(q, load_factor)):
            self._left()
            return False
        return super().is_minimum(q, load_factor, factors, flat)

    def determinant_sign(self, q: Floats, load_factor: float, factors: Factors) -> int:
        """See `Model.determinant_sign`; raises `LeavesPlane` where it is negative out of the plane."""
        try:
            across = self.across.system.factorise(self.across_tangent(q, load_factor)).determinant_sign
        except SingularMatrixError:
            across = -1
        if across < 0:
            self._left()
        return across * factors.determinant_sign

    def _left(self) -> None:
        """An equilibrium gives way to motions out of the plane."""
        if not self.stays:
            raise LeavesPlane
