r"""Contact of a rod with a rigid obstacle, without friction.

The gap of a point of the axis is its distance from the obstacle less the radius of the section, g = D(r) - R.
With the law of contact_law.py, r = N e and n, H of obstacles.py,

    V = k psi(a - g),   Q = N^T k rho n,   dQ/de = N^T k (rho H - rho' n n^T) N.

Contact is passive: an obstacle is there from the beginning, whatever the load factor.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.contact_law import PenaltyLaw
from ancf.contact_points import ContactPoints, contact_points
from ancf.effects import Effect, blocks_of
from ancf.errors import Message, SceneError
from ancf.obstacles import Obstacle
from ancf.rod_model import RodModel
from ancf.scene import Scene

Floats = NDArray[np.float64]

# Of the radius, by which a rod may stand in an obstacle in the reference: rounding of what was written.
TOUCHING = 1e-4
# Of the radii of obstacle and section together, by which a step may take a point on from where it touches:
# it then cannot have come out on the other side.
LARGEST_DIVE = 0.5


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Contacts of the scene."""
    models = {model.rod.name: model for model in rods}
    found: list[Effect] = []
    for index, contact in enumerate(scene.contacts):
        if contact.obstacle is not None:
            found.append(ObstacleContact(models[contact.rod], contact.obstacle, index))
        elif contact.other is not None:
            from ancf.effects.rod_contact import RodContact

            found.append(RodContact(models[contact.rod], models[contact.other], index))
    return found


class ObstacleContact(Effect):
    """Contact of one rod with one obstacle; blocks are the elements."""

    name = "contact"
    passive = True
    settles = True

    def __init__(self, model: RodModel, obstacle: Obstacle, index: int = 0) -> None:
        self.rod = model.rod.name
        self.obstacle = obstacle
        self.base = model.rod.base.position
        self.points = contact_points(model, obstacle.radius)
        self.dofs = model.dofs
        self.law = PenaltyLaw(self.points.k, self.points.radius)
        refuse_penetration(self.points, self.gaps(model.e0), self.rod, f"the {obstacle.shape}", index)

    def places(self, e: Floats) -> Floats:
        """Points of the axis (m, points, 3) [m, SCS]."""
        return self.points.N @ e + self.base

    def gaps(self, e: Floats) -> Floats:
        """g (m, points) [m]."""
        return self.obstacle.distance(self.places(e))[0] - self.points.radius

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        D, n, _ = self.obstacle.distance(self.places(e))
        size = self.law.k * self.law.depth(D - self.points.radius)
        return np.swapaxes(self.points.N, 1, 2) @ (size[..., None] * n)

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; symmetric."""
        D, n, H = self.obstacle.distance(self.places(e))
        g, N = D - self.points.radius, self.points.N
        size, slope = self.law.k * self.law.depth(g), self.law.k * self.law.slope(g)
        dF = size[..., None, None] * H - slope[..., None, None] * (n[..., :, None] * n[..., None, :])
        K = np.zeros((len(N), N.shape[2], 3, N.shape[2], 3))
        near = np.any(slope > 0.0, axis=1)
        K[near] = np.einsum("mpi,mpj,mpab->miajb", N[near], N[near], dF[near], optimize=True)
        nd = 3 * N.shape[2]
        return np.swapaxes(N, 1, 2) @ (size[..., None] * n), K.reshape(len(N), nd, nd)

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`."""
        return self.law.energy(self.gaps(e))

    def augment(self, q: Floats) -> bool:
        """See `Effect.augment`."""
        return self.law.augment(self.gaps(blocks_of(q, self.dofs)))

    def release(self) -> None:
        """See `Effect.release`."""
        self.law.release()

    def room(self, q: Floats, q_new: Floats) -> float:
        """See `Effect.room`: a plane has no other side; from a body a point keeps its distance, or dives."""
        if self.obstacle.radius == np.inf:
            return np.inf
        way = np.linalg.norm(self.points.N @ blocks_of(q_new - q, self.dofs), axis=-1)
        dive = LARGEST_DIVE * (self.obstacle.radius + self.points.radius)
        free = np.clip(self.gaps(blocks_of(q, self.dofs)), 0.0, None) + dive
        return float(np.min(free / np.maximum(way, 1e-300)))

    def report(self, e: Floats) -> dict[str, Any]:
        """The contact's entry in the result; `zone` are the first and last place in contact."""
        D, n, _ = self.obstacle.distance(self.places(e))
        g = D - self.points.radius
        return {"rod": self.rod, "with": self.obstacle.shape} | contact_report(self, g, n)


def contact_report(effect: Any, g: Floats, n: Floats) -> dict[str, Any]:
    """Gaps, force on the rod and zone from gaps g and normals n of the points of an effect."""
    size = effect.law.k * effect.law.depth(g)
    touching = (g <= effect.law.d) & (size > 0.0)
    places = effect.points.at[touching]
    return {
        "gap": float(g.min()),
        "penetration": max(-float(g.min()), 0.0),
        "force": np.einsum("mp,mpa->a", size, n).tolist(),
        "points": len(np.unique(np.round(places, 12))),
        "zone": [float(places.min()), float(places.max())] if len(places) else None,
    }


def refuse_penetration(points: ContactPoints, g: Floats, rod: str, other: str, index: int) -> None:
    """Refuse gaps g (m, points) in the reference that are none; `index` is that of the `[[contact]]`."""
    m, p = np.unravel_index(np.argmin(g + TOUCHING * points.radius), g.shape)
    radius, at = points.radius[m, p], points.at[m, p]
    if g[m, p] < -TOUCHING * radius:
        raise SceneError(
            Message(
                "The rod stands in an obstacle from the beginning.",
                f"contact[{index}], rod {rod!r}, at {at:.4g} of its length",
                f"gap {g[m, p]:.4g} m to {other}, must be >= 0",
                f"the gap counts from the surface of the rod, {radius:.4g} m from its axis",
                "move the obstacle or the base of the rod by that much; a plane's normal points out of it",
            )
        )
