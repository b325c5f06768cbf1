r"""Contact of a rod with another rod, or with itself, under Coulomb friction (see frictional_contact.py).

At an accepted equilibrium a point r_A and its closest point r_B touch with the material points of both
surfaces at -R_A n and R_B n from the axes, fixed to their sections by the weights W_A, W_B. In the next step

    u = W_A e_A - W_B e_B

is their way against each other, 0 there but for the gap along n: a rigid motion of both rods leaves it so.
With T of friction_law.py, l_se and l_ss of rod_contact.py, and I - n n^T over l = A,

    Q = k rho J^T n + (W_A, -W_B)^T T,   dp = -k rho' n . J de,   dn = A (J + t l_se/l_ss) de.

The element where the surface point of B lies is that of the last equilibrium, the one that contact looks at
the present one: blocks have three elements.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.contact_law import CLOSED, GROWTH
from ancf.contact_points import section_slopes, surface_weights
from ancf.effects import blocks_of
from ancf.effects.contact import count_places
from ancf.effects.frictional_contact import SOFT
from ancf.effects.rod_contact import Closest, Pairs, RodContact, at_places
from ancf.friction_law import Traction, derivative, traction
from ancf.rod_model import RodModel

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class RodAnchors:
    """What friction remembers of the last accepted equilibrium, at all points of A (flat).

    W_A, W_B (points, nodal) weights of the surface points that touched, `element` (points,) of B where the
    second lies; `near` (points,): where there was one within a radius; T (points, 3) [N]; a [m] and k [N/m]
    of the normal law; dissipated [J] up to there.
    """

    W_A: Floats
    W_B: Floats
    element: Indices
    near: NDArray[np.bool_]
    T: Floats
    a: Floats
    k: Floats
    dissipated: float


@dataclass(frozen=True, eq=False)
class RodTouch:
    """The pairs: closest points, weights of J, gaps of all points, normal forces, ways, tangential forces."""

    found: Closest
    weights: Floats
    g: Floats
    p: Floats
    W: Floats  # (pairs, nodal of A and B)
    u: Floats
    friction: Traction

    @property
    def work(self) -> float:
        """What friction dissipates [J] since the anchors, by the forces at the end: too much by a step."""
        return -float(np.sum(self.friction.T * self.u))


class FrictionalRodContact(RodContact):
    """Contact of the points of rod `a` with the axis of rod `b` under friction."""

    path_dependent = True
    anchors: RodAnchors | None = None

    def __init__(self, a: RodModel, b: RodModel, friction: float, index: int = 0) -> None:
        super().__init__(a, b, index)
        self.friction = friction
        self.release()

    def _elements(self, pairs: Pairs) -> list[tuple[RodModel, Indices]]:
        """See `RodContact._elements`; and the element of B where the anchors lie."""
        last = pairs.element if self.anchors is None else self.anchors.element[pairs.point]
        return [*super()._elements(pairs), (self.b, last)]

    def _stiffness(self) -> Floats:
        """Tangential stiffness [N/m] of the pairs in the present Newton run."""
        return self.stickiness * self.law.k.ravel()[self.pairs.point]

    def _touch(self, e: Floats) -> RodTouch:
        assert self.anchors is not None
        found, weights, g = self._at(e)
        point, nodal = self.pairs.point, self._N.shape[1]
        p = (self.law.k * self.law.depth(g)).ravel()[point]
        W_A, W_B = self.anchors.W_A[point], self.anchors.W_B[point]
        e = e[self._block]
        u = np.einsum("pn,pnc->pc", W_A, e[:, :nodal]) + self.base
        u -= np.einsum("pn,pnc->pc", W_B, e[:, -W_B.shape[1] :])
        W = np.concatenate([W_A, np.zeros_like(W_B), -W_B], axis=1)
        limit = np.where(self.anchors.near[point], self.friction * p, 0.0)
        rubs = traction(limit, self._stiffness(), found.n, u, self.multiplier[point])
        return RodTouch(found, weights, g, p, W, u, rubs)

    def _forces(self, touch: RodTouch) -> Floats:
        on = np.flatnonzero(touch.p)
        Q = touch.W[on, :, None] * touch.friction.T[on, None]
        Q[:, : touch.weights.shape[1]] += (
            touch.weights[on, :, None] * (touch.p[on, None] * touch.found.n[on])[:, None]
        )
        return self._summed(Q, on)

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        return self._forces(self._touch(e))

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; unsymmetric."""
        touch = self._touch(e)
        slope = self._sizes(touch.g)[1]
        on = np.flatnonzero(slope)
        n, weights, W = touch.found.n[on], touch.weights[on], touch.W[on]
        turning = self._turning(self._split(e)[1][on], touch.found.taken(on), weights)
        across, t, l_se, l_ss = turning
        pairs, both, all_three = len(on), 3 * weights.shape[1], 3 * W.shape[1]
        dn = np.einsum("pac,pn->panc", across, weights).reshape(pairs, 3, both)
        dn += (across @ t[:, :, None]) * (l_se / l_ss[:, None])[:, None, :]
        dp = -slope[on, None] * (weights[:, :, None] * n[:, None]).reshape(pairs, both)
        by_u, by_n, by_p = derivative(touch.friction.taken(on), self.friction, self._stiffness()[on], n)
        dT = np.einsum("pac,pn->panc", by_u, W).reshape(pairs, 3, all_three)
        dT[:, :, :both] += by_n @ dn + by_p[:, :, None] * dp[:, None, :]
        K = (W[:, :, None, None] * dT[:, None]).reshape(pairs, all_three, all_three)
        K[:, :both, :both] += self._tangent(n, weights, turning, touch.p[on], slope[on])
        return self._forces(touch), self._summed(K, on)

    def potential(self, e: Floats) -> None:
        """See `Effect.potential`: friction has none."""
        return

    def augment(self, q: Floats) -> bool:
        """See `Effect.augment`."""
        touch = self._touch(blocks_of(q, self.dofs))
        point = self.pairs.point
        change = np.linalg.norm(touch.friction.T - self.multiplier[point], axis=-1)
        slipped = bool(np.any(change > CLOSED * self.points.radius.ravel()[point] * self._stiffness()))
        if not (super().augment(q) or slipped):
            return False
        self.multiplier = self.multiplier.copy()
        self.multiplier[point] = touch.friction.T
        self.stickiness = min(GROWTH * self.stickiness, 1.0)
        return True

    def release(self) -> None:
        """See `Effect.release`: back to the reference, where nothing has slipped."""
        super().release()
        self._anchor(self.a.e0, self.b.e0, np.zeros((self.law.k.size, 3)), 0.0)

    def restart(self) -> None:
        """See `Effect.restart`."""
        assert self.anchors is not None
        self.law.go_on(self.anchors.a, self.anchors.k)
        self.multiplier = self.anchors.T
        self.stickiness = SOFT

    def commit(self, q: Floats) -> None:
        """See `Effect.commit`."""
        assert self.anchors is not None
        touch = self._touch(blocks_of(q, self.dofs))
        T = np.zeros((self.law.k.size, 3))
        T[self.pairs.point] = touch.friction.T
        dissipated = self.anchors.dissipated + touch.work
        self._anchor(self.a.element_vectors(q), self.b.element_vectors(q), T, dissipated)
        self.search(q)

    def _anchor(self, e_a: Floats, e_b: Floats, T: Floats, dissipated: float) -> None:
        """Take the points that touch, or would touch next, under tangential forces T; no pairs yet."""
        pairs = self._search(e_a, e_b)
        point, element = pairs.point, pairs.element
        of_a, of_b = e_a[self._of[point]], e_b[element]
        found = self._closest(pairs, of_a, of_b)
        R_a, R_b = self.points.radius.ravel()[point], self._radius_b[element]
        slopes_a = None if self.points.slopes is None else self._flat_slopes[point][:, None]
        slopes_b = None
        if self.b.element.has_section:
            h, kind = self.b.mesh.h[element], self.b.element
            slopes_b = at_places(self.b, found.xi, h, lambda xi, h: section_slopes(kind, xi, h))[:, None]
        arms = (-R_a[:, None] * found.n, R_b[:, None] * found.n)
        W_a = surface_weights(self._N[point][:, None], slopes_a, of_a, arms[0][:, None])[:, 0]
        W_b = surface_weights(found.shapes[0][:, None], slopes_b, of_b, arms[1][:, None])[:, 0]
        count = self.law.k.size
        elements, near = np.zeros(count, dtype=np.intp), np.zeros(count, dtype=bool)
        elements[point], near[point] = element, found.length - R_a - R_b <= R_a
        weights = _all(count, point, W_a), _all(count, point, W_b)
        self.anchors = RodAnchors(*weights, elements, near, T, self.law.a, self.law.k, dissipated)
        self._set(pairs.taken(np.zeros(len(point), dtype=bool)))
        self.restart()

    @property
    def _flat_slopes(self) -> Floats:
        assert self.points.slopes is not None
        return self.points.slopes.reshape(-1, *self.points.slopes.shape[2:])

    def report(self, e: Floats) -> dict[str, Any]:
        """See `RodContact.report`; of the tangential forces on `rod` under "friction"."""
        assert self.anchors is not None
        touch, entry = self._touch(e), super().report(e)
        rubs = np.zeros(3) if self.a is self.b else touch.friction.T.sum(axis=0)
        entry["force"] = (np.array(entry["force"]) + rubs).tolist()
        carries, slips = touch.p > 0.0, touch.friction.slips
        at = self.points.at.ravel()[self.pairs.point]
        entry["friction"] = {
            "coefficient": self.friction,
            "force": rubs.tolist(),
            "sticking": count_places(at[carries & ~slips]),
            "slipping": count_places(at[carries & slips]),
            "dissipated": self.anchors.dissipated + touch.work,
        }
        return entry


def _all(count: int, point: Indices, weights: Floats) -> Floats:
    """Weights of all points, zero where a point has no pair."""
    found = np.zeros((count, weights.shape[1]))
    found[point] = weights
    return found
