r"""Magnetised rod in a uniform field: couple per length m = (R p) x B, p = (B_r/mu_0) A, V = -int R p . B dx.

B_r (3,) [T] is the remanence, fixed to the material, B (3,) [T] the flux density of the field: in soft
material with hard-magnetic particles the remanence is independent of the field (Kim, Yuk, Zhao, Chester and
Zhao, Nature 558 (2018) 274). A uniform field exerts no force.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.effects import Effect
from ancf.mesh import reference_axis
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.rotation import hat
from ancf.scene import Scene
from ancf.section_couples import SectionCouples, all_sections
from ancf.section_spin import SectionAxes, cross

Floats = NDArray[np.float64]

MU_0 = 1.25663706127e-6  # N/A2, CODATA 2022


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Magnetised rods of the scene, in its field."""
    models = {model.rod.name: model for model in rods}
    return [MagneticCouple(models[m.rod], m.remanence, m.field) for m in scene.magnets]


class MagneticCouple(SectionCouples):
    """Couple of a uniform field (3,) [T] in SCS on a rod of remanence (3,) [T] in section axes."""

    name = "magnet"

    def __init__(self, model: RodModel, remanence: Floats, field: Floats) -> None:
        super().__init__(*all_sections(model))
        xi, _ = gauss(model.axial_points)
        area = [[model.section_in(e, float(s)).area for s in xi] for e in range(len(model.dofs))]
        _, frame = reference_axis(model.axial_abscissae.ravel(), model.rod.curvature)
        axes = (model.rod.base.rotation @ frame).reshape(*model.axial_abscissae.shape, 3, 3)
        moment = np.array(area)[..., None] / MU_0 * (axes @ remanence)  # A m2/m, SCS at the reference
        in_axes = (self.E @ moment.reshape(-1, 3, 1))[..., 0]
        self.p = self.weight * in_axes.T  # (3, m points) A m2
        self.hat_p = hat(self.p.T)
        self.field = field

    def couple(self, axes: SectionAxes) -> Floats:
        """See `SectionCouples.couple`."""
        return cross(self.p, axes.local(self.field))

    def couple_change(self, axes: SectionAxes, M: Floats) -> Floats:
        """See `SectionCouples.couple_change`: the field turns against the section, dB = B x dw."""
        return self.hat_p @ hat(axes.local(self.field).T)

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`."""
        return -float(np.sum(self.p * self.axes(e).local(self.field)))
