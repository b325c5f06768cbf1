r"""Contact of a rod with another rod, or with itself, without friction.

Each point r_A of one rod looks for the closest point of the other's axis r_B(s); the gap is
g = |r_A - r_B(s)| - R_A - R_B. With D = r_A - r_B = l n, J de = dr_A - dr_B at fixed s, and ' = d/ds,

    Q = k rho J^T n,    dQ/de = k (rho l_ee - rho' (J^T n)(J^T n)^T),
    l_ee = J^T (I - n n^T) J/l - l_se^T l_se/l_ss,
    l_se = -r_B'^T (I - n n^T) J/l - n^T N_B',   l_ss = |r_B'|^2/l - n . r_B'',

where the closest point is inside (n . r_B' = 0); at an end of the axis s stays, and only the first part is
left. Which element of the other rod a point looks at is fixed in a Newton run, and looked for again between
runs; s may go a little beyond that element. Neighbours along one rod do not touch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from ancf.contact_law import CLOSED, PenaltyLaw
from ancf.contact_points import contact_points
from ancf.effects import Effect
from ancf.effects.contact import LARGEST_DIVE, contact_report, refuse_penetration
from ancf.rod_model import RodModel

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

SAMPLES = 8  # of an element, from which the search for the closest point begins
BEYOND = 0.25  # of half an element, by which a closest point may leave its element in a run
ITERATIONS, STILL = 30, 1e-14  # of Newton on the arc; of half an element
# Of both radii together: a pair is looked at from this distance on.
NEAR = 1.0
# Of the radius, along the arc: a rod cannot be bent more than to its own radius, where it meets itself
# after half a turn on either side.
NEIGHBOURS = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Pairs:
    """Points of rod A (flat) and the elements of rod B that they look at, where low <= xi <= high."""

    point: Indices
    element: Indices
    low: Floats
    high: Floats
    start: Floats

    def taken(self, which: NDArray[np.bool_]) -> Pairs:
        """Some of them."""
        return Pairs(*(values[which] for values in vars(self).values()))


@dataclass(frozen=True, eq=False)
class Closest:
    """Closest points: xi on the other element, whether it is inside, distance l, direction n, N_B."""

    xi: Floats
    free: NDArray[np.bool_]
    length: Floats
    n: Floats
    shapes: tuple[Floats, Floats, Floats]  # N_B and its derivatives by x (pairs, nodal)


class RodContact(Effect):
    """Contact of the points of rod `a` with the axis of rod `b`, which may be the same."""

    name = "contact"
    passive = True
    coupled = True
    settles = True

    def __init__(self, a: RodModel, b: RodModel, index: int = 0) -> None:
        self.a, self.b = a, b
        radius_b = float(max(part.section.outer_radius for part in b.rod.parts))
        self.points = contact_points(a, radius_b)
        # A rod that touches itself does so from both sides.
        k = self.points.k * (0.5 if a is b else 1.0)
        self.law = PenaltyLaw(k, self.points.radius)
        self._N = self.points.N.reshape(-1, self.points.N.shape[2])  # (all points, nodal)
        self._of = np.repeat(np.arange(len(a.dofs)), self.points.N.shape[1])  # element of each point
        self._radius_b = np.array(
            [b.rod.section_at(float(x / b.rod.length)).outer_radius for x in _middles(b)]
        )
        self._samples = np.linspace(-1.0, 1.0, SAMPLES + 1)
        self._N_samples = np.array([b.element.shape(self._samples, float(h))[:, 0] for h in b.mesh.h])
        self.base = a.rod.base.position - b.rod.base.position  # of A as seen from B
        reference = self._search(a.e0, b.e0)
        g = self._all_gaps(reference, a.e0, b.e0)
        refuse_penetration(self.points, g, a.rod.name, f"rod {b.rod.name!r}", index)
        self._set(reference.taken(np.zeros(len(reference.point), dtype=bool)))

    def _set(self, pairs: Pairs) -> None:
        """Take pairs; those between the same two elements share a block."""
        key = self._of[pairs.point] * len(self.b.dofs) + pairs.element
        blocks, self._block = np.unique(key, return_inverse=True)
        self.pairs = pairs
        self.dofs = np.concatenate(
            [self.a.dofs[blocks // len(self.b.dofs)], self.b.dofs[blocks % len(self.b.dofs)]], axis=1
        )

    def _summed(self, values: Floats) -> Floats:
        """Values of the pairs summed by block."""
        total = np.zeros((len(self.dofs), *values.shape[1:]))
        np.add.at(total, self._block, values)
        return total

    def _search(self, e_a: Floats, e_b: Floats) -> Pairs:
        """The nearest element of B for every point of A, from samples."""
        r_a = np.einsum("pn,pnc->pc", self._N, e_a[self._of]) + self.base
        r_b = self._N_samples @ e_b
        count, size = r_b.shape[:2]
        distance = cdist(r_a, r_b.reshape(-1, 3))
        breaks, h = self.b.mesh.breaks, self.b.mesh.h
        arc_a = self.points.at.ravel() * self.a.rod.length
        reach = NEIGHBOURS * self.points.radius.ravel()
        if self.a is self.b:
            arc_b = (breaks[:-1, None] + 0.5 * h[:, None] * (1.0 + self._samples)).ravel()
            distance[np.abs(arc_b - arc_a[:, None]) < reach[:, None]] = np.inf
        nearest = np.argmin(distance, axis=1)
        element, sample = nearest // size, nearest % size
        low, high = np.full(len(r_a), -1.0 - BEYOND), np.full(len(r_a), 1.0 + BEYOND)
        low[element == 0], high[element == count - 1] = -1.0, 1.0
        start = self._samples[sample]
        if self.a is self.b:
            middle, half = 0.5 * (breaks[:-1] + breaks[1:])[element], 0.5 * h[element]
            after = middle + half * start > arc_a
            low = np.where(after, np.maximum(low, (arc_a + reach - middle) / half), low)
            high = np.where(after, high, np.minimum(high, (arc_a - reach - middle) / half))
            low = np.minimum(low, start)
            high = np.maximum(high, start)
        found = np.isfinite(distance[np.arange(len(r_a)), nearest])
        return Pairs(np.arange(len(r_a)), element, low, high, start).taken(found)

    def _closest(self, pairs: Pairs, e_a: Floats, e_b: Floats) -> Closest:
        """Closest points of pairs with nodal vectors e_a, e_b (pairs, nodal, 3)."""
        r_a = np.einsum("pn,pnc->pc", self._N[pairs.point], e_a) + self.base
        xi, h = pairs.start.copy(), self.b.mesh.h[pairs.element]
        for _ in range(ITERATIONS):
            N, N_x, N_xx = (_shape(self.b, xi, h, order) for order in (0, 1, 2))
            D = r_a - np.einsum("pn,pnc->pc", N, e_b)
            t, t_x = np.einsum("pn,pnc->pc", N_x, e_b), np.einsum("pn,pnc->pc", N_xx, e_b)
            slope = np.sum(D * t, axis=1)  # of -|D|^2/2
            size = np.sum(t * t, axis=1)
            curvature = np.maximum(size - np.sum(D * t_x, axis=1), 0.1 * size)
            new = np.clip(xi + 2.0 / h * slope / curvature, pairs.low, pairs.high)
            still = bool(np.all(np.abs(new - xi) <= STILL))
            xi = new
            if still:
                break
        shapes = tuple(_shape(self.b, xi, h, order) for order in (0, 1, 2))
        D = r_a - np.einsum("pn,pnc->pc", shapes[0], e_b)
        length = np.maximum(np.linalg.norm(D, axis=1), 1e-300)
        free = (xi > pairs.low) & (xi < pairs.high)
        return Closest(xi, free, length, D / length[:, None], (shapes[0], shapes[1], shapes[2]))

    def _gap(self, pairs: Pairs, length: Floats) -> Floats:
        """Gaps (all points of A), inf where a point has no pair."""
        g = np.full(self.law.k.size, np.inf)
        g[pairs.point] = length - self.points.radius.ravel()[pairs.point] - self._radius_b[pairs.element]
        return g.reshape(self.law.k.shape)

    def _all_gaps(self, pairs: Pairs, e_a: Floats, e_b: Floats) -> Floats:
        found = self._closest(pairs, e_a[self._of[pairs.point]], e_b[pairs.element])
        return self._gap(pairs, found.length)

    def gaps(self, q: Floats) -> Floats:
        """g (m, points) [m] of all points with what is nearest to them at q (n,)."""
        e_a, e_b = self.a.element_vectors(q), self.b.element_vectors(q)
        return self._all_gaps(self._search(e_a, e_b), e_a, e_b)

    def _split(self, e: Floats) -> tuple[Floats, Floats]:
        """Nodal vectors of the two elements of each pair, from those of the blocks."""
        nodal, e = self._N.shape[1], e[self._block]
        return e[:, :nodal], e[:, nodal:]

    def _at(self, e: Floats) -> tuple[Closest, Floats, Floats]:
        """Closest points of the pairs, weights of J (pairs, nodal of both), and all gaps."""
        found = self._closest(self.pairs, *self._split(e))
        weights = np.concatenate([self._N[self.pairs.point], -found.shapes[0]], axis=1)
        return found, weights, self._gap(self.pairs, found.length)

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        found, weights, g = self._at(e)
        size = (self.law.k * self.law.depth(g)).ravel()[self.pairs.point]
        return self._summed(np.einsum("p,pn,pc->pnc", size, weights, found.n))

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; symmetric."""
        found, weights, g = self._at(e)
        size, slope = (
            (self.law.k * values).ravel()[self.pairs.point]
            for values in (self.law.depth(g), self.law.slope(g))
        )
        n, length = found.n, found.length
        across = (np.eye(3) - n[:, :, None] * n[:, None, :]) / length[:, None, None]
        dF = size[:, None, None] * across - slope[:, None, None] * (n[:, :, None] * n[:, None, :])
        nd = 3 * weights.shape[1]
        K = np.einsum("pm,pn,pab->pmanb", weights, weights, dF).reshape(len(weights), nd, nd)
        _, e_b = self._split(e)
        _, N_x, N_xx = found.shapes
        t, t_x = np.einsum("pn,pnc->pc", N_x, e_b), np.einsum("pn,pnc->pc", N_xx, e_b)
        l_ss = np.sum(t * t, axis=1) / length - np.sum(n * t_x, axis=1)
        l_se = -np.einsum("pn,pab,pb->pna", weights, across, t)
        l_se[:, self._N.shape[1] :] -= N_x[:, :, None] * n[:, None, :]
        l_se = l_se.reshape(len(weights), nd)
        share = np.where(found.free & (l_ss > 0.0), size / np.where(l_ss > 0.0, l_ss, 1.0), 0.0)
        K -= share[:, None, None] * l_se[:, :, None] * l_se[:, None, :]
        return self._summed(np.einsum("p,pn,pc->pnc", size, weights, n)), self._summed(K)

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`."""
        return self.law.energy(self._at(e)[2])

    def search(self, q: Floats) -> None:
        """See `Effect.search`."""
        e_a, e_b = self.a.element_vectors(q), self.b.element_vectors(q)
        pairs = self._search(e_a, e_b)
        g = self._all_gaps(pairs, e_a, e_b).ravel()[pairs.point]
        reach = NEAR * (self.points.radius.ravel()[pairs.point] + self._radius_b[pairs.element])
        self._set(pairs.taken((g < reach) | (self.law.a.ravel()[pairs.point] > 0.0)))

    def augment(self, q: Floats) -> bool:
        """See `Effect.augment`: multipliers, and pairs that are no longer the nearest."""
        e_a, e_b = self.a.element_vectors(q), self.b.element_vectors(q)
        now = self.gaps(q)
        used = self._all_gaps(self.pairs, e_a, e_b)
        nearer = (now < self.law.d) & (now < used - CLOSED * self.law.radius)
        if np.any(nearer):
            return True  # the next run begins with a new search
        return self.law.augment(used)

    def release(self) -> None:
        """See `Effect.release`."""
        self.law.release()

    def room(self, q: Floats, q_new: Floats) -> float:
        """See `Effect.room`: by the motion of a point against the point that it looks at."""
        old = [rod.element_vectors(q) for rod in (self.a, self.b)]
        new = [rod.element_vectors(q_new) for rod in (self.a, self.b)]
        pairs = self._search(*old)
        found = self._closest(pairs, old[0][self._of[pairs.point]], old[1][pairs.element])
        g = self._gap(pairs, found.length).ravel()[pairs.point]
        d_a, d_b = new[0] - old[0], new[1] - old[1]
        way = np.einsum("pn,pnc->pc", self._N[pairs.point], d_a[self._of[pairs.point]])
        way -= np.einsum("pn,pnc->pc", found.shapes[0], d_b[pairs.element])
        dive = LARGEST_DIVE * (self.points.radius.ravel()[pairs.point] + self._radius_b[pairs.element])
        free = np.clip(g, 0.0, None) + dive
        return float(np.min(free / np.maximum(np.linalg.norm(way, axis=1), 1e-300), initial=np.inf))

    def report(self, e: Floats) -> dict[str, Any]:
        """The contact's entry in the result; the force is that on `rod`."""
        found, _, g = self._at(e)
        n = np.zeros((g.size, 3))
        n[self.pairs.point] = found.n
        entry = contact_report(self, g, n.reshape(*g.shape, 3))
        if not np.isfinite(entry["gap"]):
            entry["gap"] = None  # farther than pairs are looked at
        if self.a is self.b:
            entry["force"] = [0.0, 0.0, 0.0]  # what a rod does to itself
        return {"rod": self.a.rod.name, "with": self.b.rod.name} | entry


def _middles(rod: RodModel) -> Floats:
    return 0.5 * (rod.mesh.breaks[:-1] + rod.mesh.breaks[1:])


def _shape(rod: RodModel, xi: Floats, h: Floats, order: int) -> Floats:
    """Weights of the axis (pairs, nodal) at places xi of elements of lengths h, derivative by x."""
    found = np.empty((len(xi), rod.element.vectors_per_element))
    for size in np.unique(np.round(h / rod.rod.length, 12)):  # lengths that differ by rounding are equal
        here = np.abs(h / rod.rod.length - size) <= 1e-11
        found[here] = rod.element.shape(xi[here], float(h[here][0]), order)[:, 0]
    return found
