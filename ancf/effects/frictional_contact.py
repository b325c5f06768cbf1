r"""Contact of a rod with a rigid obstacle under Coulomb friction, quasi-static along the load steps.

To the normal force of contact.py comes the tangential force T of friction_law.py on the material point of
the rod's surface that touched at the last accepted equilibrium. It is fixed to its section by A = F^-1 (-R n)
with F = [r_x r_y r_z], so W = N + A . slopes gives its way u = W e - x from its place x then, and

    Q = N^T p n + W^T T,   dQ/de = N^T dF N + W^T (dT/du W + (dT/dn H - dT/dp k rho' n^T) N).

So friction rolls and twists a rod. A cable has no sections: friction acts on its axis. A point that was
farther away than a radius slides freely in the step that brings it into contact.

Loads are ramped in proportion, in steps of at most 1/friction_steps of the full load, and every step settles;
the answer of Coulomb's law is the limit of many steps, to first order in their size.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.contact_law import CLOSED, GROWTH
from ancf.contact_points import surface_weights
from ancf.effects import blocks_of
from ancf.effects.contact import ObstacleContact, contact_report, count_places
from ancf.friction_law import Traction, derivative, traction
from ancf.obstacles import Obstacle
from ancf.rod_model import RodModel

Floats = NDArray[np.float64]

# Tangential stiffness, in units of the normal one, of the first Newton run of a step: the softer, the wider
# the range in which a point sticks, and the less Newton leaps over it. Rounds of augmentation stiffen it.
SOFT = 1.0 / 64.0


@dataclass(frozen=True, eq=False)
class Anchors:
    """What friction remembers of the last accepted equilibrium, at all points (m, points).

    W (m, points, nodal) weights of the touching points, x (m, points, 3) [m] their places, T (m, points, 3)
    [N]; near (m, points): the obstacle is within a radius; a [m] and k [N/m] of the normal law; dissipated
    [J] up to there.
    """

    W: Floats
    x: Floats
    T: Floats
    near: NDArray[np.bool_]
    a: Floats
    k: Floats
    dissipated: float


@dataclass(frozen=True, eq=False)
class Touch:
    """All points: gap, normal, its derivative, normal force, way since the anchors, tangential force."""

    g: Floats
    n: Floats
    H: Floats
    p: Floats
    u: Floats
    friction: Traction

    @property
    def work(self) -> float:
        """What friction dissipates [J] since the anchors, by the forces at the end: too much by a step."""
        return -float(np.sum(self.friction.T * self.u))


class FrictionalContact(ObstacleContact):
    """Contact of one rod with one obstacle under friction."""

    path_dependent = True

    def __init__(self, model: RodModel, obstacle: Obstacle, friction: float, index: int = 0) -> None:
        super().__init__(model, obstacle, index)
        self.friction = friction
        self.e0 = model.e0
        self.release()

    @property
    def stiffness(self) -> Floats:
        """Tangential stiffness (m, points) [N/m] of the present Newton run."""
        return self.stickiness * self.law.k

    def _touch(self, e: Floats) -> Touch:
        D, n, H = self.obstacle.distance(self.places(e))
        g = D - self.points.radius
        p = self.law.k * self.law.depth(g)
        u = self.anchors.W @ e + self.base - self.anchors.x
        limit = np.where(self.anchors.near, self.friction * p, 0.0)
        return Touch(g, n, H, p, u, traction(limit, self.stiffness, n, u, self.multiplier))

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        return super().force(e) + np.swapaxes(self.anchors.W, 1, 2) @ self._touch(e).friction.T

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; unsymmetric."""
        Q, K = super().force_and_tangent(e)
        touch = self._touch(e)
        slope = self.law.k * self.law.slope(touch.g)
        by_u, by_n, by_p = derivative(touch.friction, self.friction, self.stiffness, touch.n)
        by_r = by_n @ touch.H - by_p[..., :, None] * (slope[..., None] * touch.n)[..., None, :]
        rubs = np.any(touch.friction.limit > 0.0, axis=1)
        W, N = self.anchors.W[rubs], self.points.N[rubs]
        rubbed = np.einsum("mpi,mpj,mpab->miajb", W, W, by_u[rubs], optimize=True)
        rubbed += np.einsum("mpi,mpj,mpab->miajb", W, N, by_r[rubs], optimize=True)
        K[rubs] += rubbed.reshape(len(W), *K.shape[1:])
        return Q + np.swapaxes(self.anchors.W, 1, 2) @ touch.friction.T, K

    def potential(self, e: Floats) -> None:
        """See `Effect.potential`: friction has none."""
        return

    def augment(self, q: Floats) -> bool:
        """See `Effect.augment`."""
        touch = self._touch(blocks_of(q, self.dofs))
        change = np.linalg.norm(touch.friction.T - self.multiplier, axis=-1)
        slipped = bool(np.any(change > CLOSED * self.points.radius * self.stiffness))
        if not (self.law.augment(touch.g) or slipped):
            return False
        self.multiplier = touch.friction.T
        self.stickiness = min(GROWTH * self.stickiness, 1.0)
        return True

    def release(self) -> None:
        """See `Effect.release`: back to the reference, where nothing has slipped."""
        super().release()
        self.anchors = self._anchors(self.e0, np.zeros((*self.points.k.shape, 3)), 0.0)
        self.restart()

    def restart(self) -> None:
        """See `Effect.restart`."""
        self.law.go_on(self.anchors.a, self.anchors.k)
        self.multiplier = self.anchors.T
        self.stickiness = SOFT

    def commit(self, q: Floats) -> None:
        """See `Effect.commit`."""
        e = blocks_of(q, self.dofs)
        touch = self._touch(e)
        self.anchors = self._anchors(e, touch.friction.T, self.anchors.dissipated + touch.work)
        self.restart()

    def _anchors(self, e: Floats, T: Floats, dissipated: float) -> Anchors:
        """The points that touch at e, or would touch next, under tangential forces T."""
        D, n, _ = self.obstacle.distance(self.places(e))
        W = surface_weights(self.points.N, self.points.slopes, e, -self.points.radius[..., None] * n)
        near = 2.0 * self.points.radius >= D
        return Anchors(W, W @ e + self.base, T, near, self.law.a, self.law.k, dissipated)

    def report(self, e: Floats) -> dict[str, Any]:
        """See `ObstacleContact.report`; of the tangential forces under "friction"."""
        touch = self._touch(e)
        entry = contact_report(self, touch.g, touch.n)
        rubs = touch.friction.T.sum(axis=(0, 1))
        entry["force"] = (np.array(entry["force"]) + rubs).tolist()
        carries, slips = touch.p > 0.0, touch.friction.slips
        entry["friction"] = {
            "coefficient": self.friction,
            "force": rubs.tolist(),
            "sticking": count_places(self.points.at[carries & ~slips]),
            "slipping": count_places(self.points.at[carries & slips]),
            "dissipated": self.anchors.dissipated + touch.work,
        }
        return {"rod": self.rod, "with": self.obstacle.shape} | entry
