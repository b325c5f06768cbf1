r"""Magnetised rod in a uniform field: couple per length m = (R p) x B, p = (B_r/mu_0) A, V = -int R p . B dx.

B_r (3,) [T] is the remanence, fixed to the material, B (3,) [T] the flux density of the field: in soft
material with hard-magnetic particles the remanence is independent of the field (Kim, Yuk, Zhao, Chester and
Zhao, Nature 558 (2018) 274). A uniform field exerts no force.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.distributed_couple import DistributedCouple
from ancf.effects import Effect
from ancf.mesh import reference_axis
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.rotation import hat
from ancf.scene import Scene

Floats = NDArray[np.float64]

MU_0 = 1.25663706127e-6  # N/A2, CODATA 2022


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Magnetised rods of the scene, in its field."""
    models = {model.rod.name: model for model in rods}
    return [MagneticCouple(models[m.rod], m.remanence, m.field) for m in scene.magnets]


class MagneticCouple(DistributedCouple):
    """Couple of a uniform field (3,) [T] in SCS on a rod of remanence (3,) [T] in section axes."""

    name = "magnet"

    def __init__(self, model: RodModel, remanence: Floats, field: Floats) -> None:
        super().__init__(model)
        xi, _ = gauss(model.axial_points)
        area = [[model.section_in(e, float(s)).area for s in xi] for e in range(len(model.dofs))]
        _, frame = reference_axis(model.axial_abscissae.ravel(), model.rod.curvature)
        axes = (model.rod.base.rotation @ frame).reshape(*model.axial_abscissae.shape, 3, 3)
        self.moment = np.array(area)[..., None] / MU_0 * (axes @ remanence)  # A m2/m, SCS at the reference
        self.field = field

    def couple(self, R: Floats) -> Floats:
        """See `DistributedCouple.couple`."""
        return np.cross(self._moment(R), self.field)

    def couple_change(self, R: Floats, m: Floats) -> Floats:
        """See `DistributedCouple.couple_change`: (dw x p) x B = hat(B) hat(p) dw."""
        return hat(self.field) @ hat(self._moment(R))

    def _moment(self, R: Floats) -> Floats:
        return (R @ self.moment[..., None])[..., 0]

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`."""
        return -float(np.sum(self.weight * self._moment(self._rotation(e).R) * self.field))
