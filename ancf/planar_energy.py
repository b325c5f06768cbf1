r"""Elastic force and tangent of a rod that is its own mirror image in a plane, on its planar unknowns.

As in energy.py, with the numbers w = N u that do not vanish in the place of whole vectors: v_i has two
components in the plane where its director is even across it, one component across it where it is odd
(mirror_unknowns.py). Of the products v_i . v_j those of an even and an odd vector vanish; the others are

    gamma_p = 1/2 (w^T G_p w - w0^T G_p w0),    G_p constant, of zeros, ones and twos,
    Q = N^T B^T T,    K = N^T (B^T H B + sum_p T_p G_p) N,    B_p = G_p w.

The tangent in the directions out of the plane, of the other parity, has the same form with the products of
one even and one odd vector in B and the components of `odd` in G: both blocks together are the full tangent.

What the axial points miss of the sections (hourglass.py) is taken from the kernel in space, as F^T K F.

For the mixed-integration-point tangent the products after a linear step dw are gamma_p - 1/2 dw^T G_p dw.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from ancf.elements import R
from ancf.mirror_unknowns import MirrorUnknowns, NodeUnknowns
from ancf.section_energy import pairs
from ancf.section_law import AlikeSections, QuadraticSection, QuadratureSection, SectionLaw
from ancf.section_terms import ProjectedTerm, QuadraticTerm, Term

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

ON_PLANE = 1e-9  # of the largest distance from the plane: section points closer are on it


@dataclass(frozen=True, eq=False)
class Products:
    """Products of the generalised vectors that do not vanish, as quadratic forms of their numbers w.

    Parameters
    ----------
    alike, mixed : pairs of vectors of one parity, and of both
    numbers, odd_numbers : which components of the vectors are not zero in the plane; motions out of it
    G : (alike, numbers, numbers) second derivatives; G_flat the same as (numbers, alike * numbers)
    G_odd : (alike, odd numbers, odd numbers); G_mixed_flat : (numbers, mixed * odd numbers)
    """

    alike: Indices
    mixed: Indices
    numbers: Indices
    odd_numbers: Indices
    G: Floats
    G_flat: Floats
    G_odd: Floats
    G_mixed_flat: Floats


@lru_cache(maxsize=64)
def products_of(even: NodeUnknowns, odd: NodeUnknowns) -> Products:
    """The products of an element that stands in a plane as the unknowns of its nodes say."""
    orders = even.element.generalised
    i, j = pairs(len(orders))
    second = np.zeros((len(i), len(orders), 3, len(orders), 3))
    for a in range(3):
        second[np.arange(len(i)), i, a, j, a] += 1.0
        second[np.arange(len(i)), j, a, i, a] += 1.0
    second = second.reshape(len(i), 3 * len(orders), -1)
    parity = np.array([even.is_odd(order) for order in orders])
    alike, mixed = np.flatnonzero(parity[i] == parity[j]), np.flatnonzero(parity[i] != parity[j])
    here, there = even.numbers(orders), odd.numbers(orders)
    G = second[np.ix_(alike, here, here)]
    G_odd, G_mixed = second[np.ix_(alike, there, there)], second[np.ix_(mixed, here, there)]
    G_flat, G_mixed_flat = (
        np.ascontiguousarray(np.moveaxis(one, 1, 0).reshape(len(here), -1)) for one in (G, G_mixed)
    )
    return Products(alike, mixed, here, there, G, G_flat, G_odd, G_mixed_flat)


@dataclass(frozen=True, eq=False)
class PlanarEnergy:
    """Elastic kernel of one rod on the unknowns in the plane; `odd` are those out of it."""

    even: MirrorUnknowns
    odd: MirrorUnknowns

    @cached_property
    def products(self) -> Products:
        """The products on which the energy depends."""
        return products_of(self.even.node, self.odd.node)

    def _shape(self, unknowns: MirrorUnknowns, numbers: Indices) -> Floats:
        """N (n_el or 1, places, numbers, unknowns of the element)."""
        N, listed = self.even.rod.elastic.N, unknowns.node.listed
        size = 3 * len(unknowns.rod.element.vectors)
        columns = (size * np.arange(len(unknowns.rod.element.node_xi))[:, None] + listed).ravel()
        same = (numbers[:, None] - columns) % 3 == 0
        return N[:, :, numbers[:, None] // 3, columns // 3] * same

    @cached_property
    def N(self) -> Floats:
        """Shape functions of the numbers w (n_el or 1, places, numbers, m)."""
        return self._shape(self.even, self.products.numbers)

    @cached_property
    def _N_stacked(self) -> Floats:
        """N of all places one below the other (n_el or 1, places * numbers, m)."""
        kinds, places, count, m = self.N.shape
        return self.N.reshape(kinds, places * count, m)

    @cached_property
    def _positions(self) -> tuple[Indices, Indices]:
        """Unknowns of an element that are positions, and for each the same one of its first node."""
        node = self.even.node
        axis = np.flatnonzero(node.listed // 3 == node.element.vectors.index(R))
        nodes = np.arange(len(node.element.node_xi))
        return (len(node.listed) * nodes[:, None] + axis).ravel(), np.tile(axis, len(nodes))

    @cached_property
    def _assumed(self) -> Floats | None:
        assumed = self.even.rod.elastic.assumed
        return None if assumed is None else assumed[:, :, self.products.alike]

    @cached_property
    def section(self) -> SectionLaw:
        """Energy of the sections as a function of the products that do not vanish."""
        node = self.even.node
        if not node.element.has_section:
            return self.even.rod.elastic.section
        slope = node.element.generalised.index((1, *((1, 0) if node.across_y else (0, 1))))
        return restricted(self.even.rod.elastic.section, self.products.alike, slope)

    @cached_property
    def _gamma0(self) -> Floats:
        w = self.numbers(self.element_unknowns(self.even.rod.e0))
        return self._quadratic(self._changes(w), w)

    def element_unknowns(self, e: Floats) -> Floats:
        """Unknowns u (n_el, m) of the nodal vectors e (n_el, nodal, 3) of the elements."""
        nodes = e.reshape(len(e), len(self.even.rod.element.node_xi), -1)
        return (nodes @ self.even.node.P.T).reshape(len(e), -1)

    def numbers(self, u: Floats) -> Floats:
        """w (..., n_el, places, numbers) of the unknowns of the elements u (..., n_el, m)."""
        positions, first = self._positions
        relative = u.copy()
        relative[..., positions] -= u[..., first]
        if len(self._N_stacked) == 1:
            w = relative @ self._N_stacked[0].T
        else:
            w = (self._N_stacked @ relative[..., None])[..., 0]
        return w.reshape(*u.shape[:-1], *self.N.shape[1:3])

    def _changes(self, w: Floats) -> Floats:
        """B = d gamma/d w (..., n_el, places, pairs, numbers)."""
        count = w.shape[-1]
        return (w.reshape(-1, count) @ self.products.G_flat).reshape(*w.shape[:-1], -1, count)

    @staticmethod
    def _quadratic(B: Floats, w: Floats) -> Floats:
        return 0.5 * (B @ w[..., None])[..., 0]

    def _at_points(self, gamma: Floats) -> Floats:
        return gamma if self._assumed is None else np.einsum("gsp,esp->egp", self._assumed, gamma)

    def _at_places(self, T: Floats) -> Floats:
        return T if self._assumed is None else np.einsum("gsp,egp->esp", self._assumed, T)

    def force_and_tangent(self, u: Floats, u_previous: Floats | None = None) -> tuple[Floats, Floats]:
        """Force (n_el, m) and symmetric tangent (n_el, m, m) at the unknowns of the elements u (n_el, m).

        With `u_previous` the geometric part uses the mixed-integration-point stress.
        """
        # The last step goes along: what is small is called half as often.
        w = self.numbers(u[None] if u_previous is None else np.stack([u, u - u_previous]))
        B = self._changes(w)
        quadratic = self._quadratic(B, w)
        B, products = B[0], quadratic[0] - self._gamma0
        T, H = self.section.response(self._at_points(products))
        Q_w = (np.swapaxes(B, -1, -2) @ self._at_places(T)[..., None])[..., 0]
        if u_previous is not None:
            w, dw, step = w[0], w[1], quadratic[1]
            before = None
            if not isinstance(self.section, QuadraticSection):  # a linear law does not ask where it is
                w_previous = w - dw
                before = self._at_points(
                    self._quadratic(self._changes(w_previous), w_previous) - self._gamma0
                )
            predicted = self._at_points(products - step)
            T = self.section.predicted(predicted if before is None else before, predicted)
        Q = self._to_nodes(Q_w)
        K = self._tangent(self.N, B, self._assumed, H, self._at_places(T), self.products.G)
        control = self.even.rod.elastic.control
        if control is None:
            return Q, K
        F = self.even.node.of_element
        Q_c, K_c = control.force_and_tangent(
            self._vectors(u), None if u_previous is None else self._vectors(u_previous)
        )
        return Q + Q_c.reshape(len(u), -1) @ F, K + F.T @ K_c @ F

    def _vectors(self, u: Floats) -> Floats:
        """Nodal vectors e (n_el, nodal, 3) of the unknowns of the elements u (n_el, m)."""
        return (u @ self.even.node.of_element.T).reshape(len(u), -1, 3)

    def odd_tangent(self, u: Floats) -> Floats:
        """Tangent (n_el, m', m') of motions out of the plane at a shape in it."""
        elastic, products = self.even.rod.elastic, self.products
        w = self.numbers(u)
        full = np.zeros((*w.shape[:-1], len(products.alike) + len(products.mixed)))
        full[..., products.alike] = self._quadratic(self._changes(w), w) - self._gamma0
        if elastic.assumed is not None:
            full = np.einsum("gsp,esp->egp", elastic.assumed, full)
        T, H = elastic.section.response(full)
        T, H = T[..., products.alike], H[..., products.mixed[:, None], products.mixed]
        shape = (*w.shape[:-1], len(products.mixed), len(products.odd_numbers))
        B = (w.reshape(-1, w.shape[-1]) @ products.G_mixed_flat).reshape(shape)
        assumed = None if elastic.assumed is None else elastic.assumed[:, :, products.mixed]
        N = self._shape(self.odd, products.odd_numbers)
        K = self._tangent(N, B, assumed, H, self._at_places(T), products.G_odd)
        if elastic.control is None:
            return K
        F = self.odd.node.of_element
        return K + F.T @ elastic.control.force_and_tangent(self._vectors(u))[1] @ F

    def _to_nodes(self, Q_w: Floats) -> Floats:
        flat = Q_w.reshape(len(Q_w), -1)
        if len(self._N_stacked) == 1:
            return flat @ self._N_stacked[0]
        return (flat[:, None] @ self._N_stacked)[:, 0]

    @staticmethod
    def _tangent(N: Floats, B: Floats, assumed: Floats | None, H: Floats, T: Floats, G: Floats) -> Floats:
        """N^T (B^T H B + sum_p T_p G_p) N; with assumed strains B^T H B belongs to the axial points."""
        n_el, places, _, count = B.shape
        m = N.shape[-1]
        K_w = (T.reshape(n_el * places, -1) @ G.reshape(len(G), -1)).reshape(n_el, places, count, count)
        if assumed is None:
            K_w += np.swapaxes(B, -1, -2) @ (H @ B)
        stacked = N.reshape(len(N), places * count, m)
        K = np.swapaxes(stacked, -1, -2) @ (K_w @ N).reshape(n_el, places * count, m)
        if assumed is not None:
            B = np.einsum("gsp,espm->egpm", assumed, B @ N)
            K += np.sum(np.swapaxes(B, -1, -2) @ (H @ B), axis=1)
        return K


def restricted(section: SectionLaw, keep: Indices, slope: int) -> SectionLaw:
    """A section law on the strain products that do not vanish, on half of its section points.

    Parameters
    ----------
    keep : which products
    slope : which generalised vector is d_x d_n r, n across the plane: its weight has the sign of n
    """
    if isinstance(section, QuadraticSection):
        return QuadraticSection(np.ascontiguousarray(section.H[..., keep[:, None], keep]))
    assert isinstance(section, QuadratureSection)
    groups = []
    for group in section.groups:
        terms: list[Term | ProjectedTerm | QuadraticTerm] = []
        for term in group.terms:
            if isinstance(term, QuadraticTerm):
                terms.append(QuadraticTerm(term.H[keep[:, None], keep]))
            else:
                half = halved(term, slope)
                terms.append(replace(half, B=half.B[..., keep]))
        groups.append(AlikeSections(group.points, group.axial_weight, tuple(terms)))
    return QuadratureSection(tuple(groups))


def halved(term: Term | ProjectedTerm, slope: int) -> Term | ProjectedTerm:
    """The points of a term on one side of the plane, for both sides; those on it count once.

    A point and its mirror image have the same energy. Of the affine functions the one that is odd across the
    plane meets even fields only and drops out.
    """
    across = term.weights_local[:, slope, 0]
    near = ON_PLANE * np.abs(across).max()
    here = np.flatnonzero(across >= -near)
    weight = np.where(across > near, 2.0, 1.0) * term.weight
    if isinstance(term, Term):
        return Term(term.potential, term.weights_local[here], term.B[here], weight[here])
    odd = int(np.argmax(np.abs((term.weight * across) @ term.affine)))
    affine = np.delete(term.affine, odd, axis=1)[here]
    return replace(
        term, weights_local=term.weights_local[here], B=term.B[here], weight=weight[here], affine=affine
    )
