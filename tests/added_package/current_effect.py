r"""An effect of another package: drag of a steady current on a rod, `[[current]]` in a scene file.

Across the axis of tangent t a current u [m/s] pushes each reference length with (Morison's drag)

    f = c |w| w,   w = (I - t t^T) u,   c = 1/2 rho C_d d,   t = r'/|r'|,

rho the density of the fluid, C_d the drag coefficient, d the width of the section. So Q = int N^T f dx and

    dw = -[(t . u) I + t u^T] dt,   dt = (I - t t^T) dr'/|r'|,   df = c (|w| I + w w^T/|w|) dw,

unsymmetric: a drag has no potential.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ancf.effects import Effect
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.scene import Rod, Scene
from ancf.scene_table import Limit, Table
from ancf.units import DENSITY, NUMBER, Dimension

SPEED = Dimension("speed", "m/s", "0.5")
POSITIVE = Limit(lambda v: v > 0.0, "> 0")
POINTS = 3  # per element; the turning direction is no polynomial


@dataclass(frozen=True, eq=False)
class Current:
    """A steady current past one rod."""

    rod: str
    velocity: np.ndarray  # (3,) m/s
    density: float  # kg/m3
    coefficient: float


def read(table: Table, rods: Sequence[Rod]) -> Current:
    """Read one `[[current]]`."""
    table.expect_keys(("rod", "velocity", "density", "coefficient"))
    return Current(
        rod=table.known(
            "rod", [rod.name for rod in rods], "rod", "the current passes a rod that is not there"
        ),
        velocity=table.vector("velocity", 3, SPEED),
        density=table.number("density", DENSITY, 1000.0, POSITIVE),
        coefficient=table.number("coefficient", NUMBER, 1.2, POSITIVE),
    )


def build(scene: Scene, rods: list[RodModel], records: Sequence[Current]) -> list[Effect]:
    """Drag on each of the rods that a table names."""
    models = {model.rod.name: model for model in rods}
    return [Drag(models[record.rod], record) for record in records]


class Drag(Effect):
    """Drag on one rod; its blocks are the elements."""

    name = "current"

    def __init__(self, model: RodModel, current: Current) -> None:
        xi, weight = gauss(POINTS)
        h = model.mesh.h
        self.dofs = model.dofs
        self.N = np.array([model.element.shape(xi, length)[:, 0] for length in h])  # (m, points, nodal)
        self.N_x = np.array([model.element.shape(xi, length, 1)[:, 0] for length in h])
        self.weight = 0.5 * h[:, None] * weight
        self.u = current.velocity
        self.c = 0.5 * current.density * current.coefficient * 2.0 * model.rod.section.outer_radius

    def force(self, e: np.ndarray) -> np.ndarray:
        """See `Effect.force`."""
        return self.force_and_tangent(e)[0]

    def force_and_tangent(self, e: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `Effect.force_and_tangent`."""
        r_x = self.N_x @ e
        stretch = np.linalg.norm(r_x, axis=-1)[..., None]
        t = r_x / stretch
        along = np.sum(t * self.u, axis=-1)[..., None]
        w = self.u - along * t
        speed = np.linalg.norm(w, axis=-1)[..., None]
        one = np.eye(3)
        dt = (one - t[..., :, None] * t[..., None, :]) / stretch[..., None]
        dw = -(along[..., None] * one + t[..., :, None] * self.u) @ dt
        safe = np.maximum(speed, 1e-300)  # along the current there is no drag, and no change of it
        df = self.c * (speed[..., None] * one + w[..., :, None] * (w / safe)[..., None, :]) @ dw
        Q = np.einsum("mp,mpn,mpa->mna", self.weight, self.N, self.c * speed * w)
        K = np.einsum("mp,mpn,mpab,mpo->mnaob", self.weight, self.N, df, self.N_x)
        return Q, K.reshape(len(K), 3 * self.N.shape[-1], -1)

    def potential(self, e: np.ndarray) -> None:
        """See `Effect.potential`: none."""
        return
