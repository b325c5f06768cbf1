"""One rod as arrays: mesh, reference vectors, elastic kernel data and section points for loads.

Symbols
-------
q0       reference nodal vectors of the rod (n_nodes, vectors, 3), positions relative to the base
dofs     unknowns of the model that belong to an element (n_el, 3 nodal)
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from ancf.assumed_strain import sampling
from ancf.cable import cable_section
from ancf.elements import ELEMENTS, Element, R
from ancf.energy import ElasticRod
from ancf.hourglass import NODES, control_weight, of_directors, swelling
from ancf.hyperelastic import Law
from ancf.materials import SaintVenantKirchhoff
from ancf.mesh import Mesh, make_mesh, reference_axis, reference_nodes, rod_breaks
from ancf.quadrature import gauss
from ancf.scene import Rod, Scene
from ancf.section_energy import (
    director_weights,
    generalised_shape,
    section_stiffness,
    section_terms,
    shared_shape,
    shear_energy_matrix,
    straight_reference,
    straight_section_stiffness,
)
from ancf.section_law import AlikeSections, QuadraticSection, QuadratureSection
from ancf.section_terms import ProjectedTerm, QuadraticTerm, Term
from ancf.sections import Section
from ancf.segments import starts
from ancf.supports import NodeSupport, support_rows

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

PIECE = 128  # elements whose kernel runs at once: some 2 MB of temporaries


@dataclass(frozen=True)
class SectionPoint:
    """One section of a rod, as maps from the nodal vectors of its element.

    directors d_k = N e, slopes d_k' = N_x e with e (nodal vectors, 3); W are the section-rotation weights.
    """

    dofs: Indices  # (3 nodal,)
    N: Floats  # (directors, nodal)
    N_x: Floats  # (directors, nodal)
    d0: Floats  # (directors, 3)
    W: Floats  # (directors, 3) [m4]


@dataclass(frozen=True)
class RodModel:
    """Arrays of one rod; `first_dof` is the position of its unknowns in the model."""

    rod: Rod
    element: Element
    mesh: Mesh
    q0: Floats
    first_dof: int

    @cached_property
    def dofs(self) -> Indices:
        """Unknowns of each element (n_el, 3 nodal), the paper's B_1 (eq. 10) as an index table."""
        per_node = 3 * len(self.element.vectors)
        nodes = self.mesh.nodes_of[:, :, None] * per_node + np.arange(per_node)
        return self.first_dof + nodes.reshape(len(nodes), -1)

    @property
    def size(self) -> int:
        """Number of unknowns of the rod, supports not yet taken off."""
        return self.q0.size

    @cached_property
    def axial_points(self) -> int:
        """Gauss points along the axis for the strain energy."""
        rule = self.rod.axial_rule
        if rule == "default":
            return self.element.axial_points
        return self.element.full_points if rule == "full" else int(rule)

    @property
    def assumes_strains(self) -> bool:
        """Whether the axial rule is the element's own and takes strains elsewhere than at its points."""
        return self.rod.axial_rule == "default" and bool(self.element.assumed)

    @cached_property
    def axial_weights(self) -> Floats:
        """Weights (n_el, points) [m] of the axial integration points."""
        _, weight = gauss(self.axial_points)
        return 0.5 * self.mesh.h[:, None] * weight

    @cached_property
    def axial_abscissae(self) -> Floats:
        """Reference arc lengths (n_el, points) [m] of the axial integration points."""
        xi, _ = gauss(self.axial_points)
        return self.mesh.breaks[:-1, None] + 0.5 * self.mesh.h[:, None] * (1.0 + xi)

    @cached_property
    def e0(self) -> Floats:
        """Reference nodal vectors per element (n_el, nodal, 3)."""
        return self.q0[self.mesh.nodes_of].reshape(len(self.mesh.nodes_of), -1, 3)

    @cached_property
    def frames0(self) -> Floats:
        """Section frames of the reference (n_nodes, 3, 3) at the nodes, columns x, y, z in SCS."""
        _, frame = reference_axis(self.mesh.node_x, self.rod.curvature)
        return self.rod.base.rotation @ frame

    @cached_property
    def part_of(self) -> Indices:
        """Which part of the rod (`Rod.parts`) each element belongs to (n_el,)."""
        middle = 0.5 * (self.mesh.breaks[:-1] + self.mesh.breaks[1:])
        return np.searchsorted(starts(self.rod.parts)[1:-1], middle, side="right")

    def elements_of(self, part: int) -> slice:
        """The elements of a part of the rod."""
        first, last = np.searchsorted(self.part_of, [part, part + 1])
        return slice(int(first), int(last))

    def material_of(self, element: int) -> Law:
        """The material of an element."""
        return self.rod.parts[self.part_of[element]].material

    def section_in(self, element: int, xi: float) -> Section:
        """The section of an element at xi, -1 to 1."""
        part = int(self.part_of[element])
        segment = self.rod.parts[part]
        if not segment.tapered:
            return segment.section
        breaks = self.mesh.breaks[self.elements_of(part).start :]
        here = element - self.elements_of(part).start
        x = breaks[here] - breaks[0] + 0.5 * (breaks[here + 1] - breaks[here]) * (1.0 + xi)
        return segment.section_at(float(x / segment.length))

    def weights_at(self, xi: Floats, d0: Floats) -> Floats:
        """Section-rotation weights (n_el, points, directors, 3) [m4] at xi (points,) of each element.

        d0 : reference directors there, (n_el, points, directors, 3)
        """
        if not self.rod.segments:
            return director_weights(self.element, self.rod.section, d0)
        sections = [self.section_in(element, float(s)) for element in range(len(d0)) for s in xi]
        return director_weights(self.element, sections, d0)

    @cached_property
    def node_weights(self) -> Floats:
        """Section-rotation weights (n_nodes, directors, 3) [m4] at the nodes."""
        columns = [self.element.vectors.index((0, j, k)) for j, k in self.element.directors]
        rod, d0 = self.rod, self.q0[:, columns]
        if not rod.segments:
            return director_weights(self.element, rod.section, d0)
        return director_weights(
            self.element, [rod.section_at(float(x / rod.length)) for x in self.mesh.node_x], d0
        )

    @cached_property
    def element_kinds(self) -> tuple[Indices, Indices]:
        """One element of each kind, and for every element the kind it belongs to.

        Alike are elements of one length, of one material, and with the same sections at their ends: the
        curvature is constant along a rod, so they are the same up to a rigid motion.
        """
        # Lengths that differ by rounding only are equal: compare 12 digits.
        relative = np.round(self.mesh.h / self.rod.length, 12)
        if not self.rod.segments:
            if (relative == relative[0]).all():
                return np.zeros(1, np.intp), np.zeros(len(relative), np.intp)
            _, first, kind = np.unique(relative, return_index=True, return_inverse=True)
            return first, kind
        labels: dict[tuple[Section, Section, Law], int] = {}
        makes = [
            labels.setdefault(
                (self.section_in(i, -1.0), self.section_in(i, 1.0), self.material_of(i)), len(labels)
            )
            for i in range(len(relative))
        ]
        keys = np.column_stack([makes, relative])
        _, first, kind = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        return first, kind.ravel()

    @cached_property
    def elastic(self) -> ElasticRod:
        """Constant data of the elastic kernel; equal elements share their data."""
        first, kind = self.element_kinds
        xi, _ = gauss(self.axial_points)
        places, assumed = sampling(self.element, self.axial_points) if self.assumes_strains else (xi, None)
        lengths = [float(self.mesh.h[index]) for index in first]
        N = np.array([shared_shape(self.element, tuple(places), h) for h in lengths])
        per_node, nodes = len(self.element.vectors), len(self.element.node_xi)
        columns = np.arange(nodes) * per_node + self.element.vectors.index(R)
        v0 = [
            shape[: len(xi)] @ _relative(self.element, self.e0[index])
            for shape, index in zip(N, first, strict=True)
        ]
        if not self.element.has_section:
            section = cable_section(self)
        elif all(isinstance(segment.material, SaintVenantKirchhoff) for segment in self.rod.parts):
            H = [
                [self._stiffness(self._local(index, s), v) for s, v in zip(xi, points, strict=True)]
                for index, points in zip(first, v0, strict=True)
            ]
            weight = self.axial_weights[first][..., None, None]
            section = QuadraticSection(_spread(weight * np.array(H), kind))
        else:
            section = QuadratureSection(self._groups(v0))
        return ElasticRod(_spread(N, kind), section, self.e0, columns, assumed, self._control(columns))

    def _control(self, position_columns: Indices) -> ElasticRod | None:
        """Energy of the sections that the default axial rule of the element misses (hourglass.py)."""
        if not (self.element.long_from and self.rod.axial_rule == "default"):
            return None
        first, kind = self.element_kinds
        N, H = [], []
        for index in first:
            h, rod = float(self.mesh.h[index]), self._local(index, 0.0)
            shape = generalised_shape(self.element, NODES, h)
            v0 = shape[1] @ _relative(self.element, self.e0[index])
            weight = control_weight(h, rod.section.radius_of_gyration, self.element.long_from)
            N.append(shape[:, len(self.element.directors) :])  # directors alone, without slopes
            H.append([weight * of_directors(self.element, shear_energy_matrix(self.element, rod, v0))])
        section = QuadraticSection(_spread(np.array(H), kind))
        return ElasticRod(
            _spread(np.array(N), kind), section, self.e0, position_columns, swelling(self.element)
        )

    @cached_property
    def pieces(self) -> list[tuple[slice, ElasticRod]]:
        """The elements in runs of `PIECE` with the kernel of each, where equal elements share their data.

        The kernel's temporaries, ten times the tangent, then stay in the cache however long the rod is.
        """
        elastic, count = self.elastic, len(self.e0)
        own = [
            value
            for name, value in vars(elastic).items()
            if name in {f.name for f in fields(elastic)} - {"e0"} and np.shape(value)[:1] == (count,)
        ]
        shared = isinstance(elastic.section, QuadraticSection) and len(elastic.section.H) == 1 and not own
        if count <= PIECE or not shared:
            return [(slice(0, count), elastic)]
        runs = [slice(first, min(first + PIECE, count)) for first in range(0, count, PIECE)]
        return [(run, _piece(elastic, run)) for run in runs]

    def _local(self, element: int, xi: float) -> Rod:
        """The prismatic rod that an element is at xi."""
        return self.rod.prismatic(self.section_in(element, xi), self.material_of(element))

    def _stiffness(self, rod: Rod, v0: Floats) -> Floats:
        """H of the (prismatic) rod at the reference generalised vectors v0."""
        if np.any(rod.curvature):
            return section_stiffness(self.element, rod, v0)
        assert isinstance(rod.material, SaintVenantKirchhoff)
        return straight_section_stiffness(
            self.element, rod.section, rod.material, rod.formulation, rod.shear_factors
        )

    def _groups(self, v0: list[Floats]) -> tuple[AlikeSections, ...]:
        """Alike sections: of a straight rod all with one section and material, of a curved one besides one
        axial point of one kind of element.
        """
        weight = self.axial_weights.ravel()
        places = np.arange(len(weight)).reshape(self.axial_weights.shape)
        first, kind = self.element_kinds
        xi, _ = gauss(self.axial_points)
        curved = bool(np.any(self.rod.curvature))
        alike: dict[object, list[Indices]] = {}
        makes: dict[object, tuple[Rod, Floats]] = {}
        for row, (index, points) in enumerate(zip(first, v0, strict=True)):
            for point, v in enumerate(points):
                rod = self._local(index, float(xi[point]))
                key = (rod.section, rod.material, (row, point) if curved else None)
                makes.setdefault(key, (rod, v if curved else straight_reference(self.element)))
                alike.setdefault(key, []).append(places[kind == row, point])
        groups = []
        for key, (rod, v) in makes.items():
            found = np.sort(np.concatenate(alike[key]))
            groups.append(AlikeSections(found, weight[found], self._terms(rod, v)))
        return tuple(groups)

    def _terms(self, rod: Rod, v0: Floats) -> tuple[Term | ProjectedTerm | QuadraticTerm, ...]:
        """Energy of the sections of the (prismatic) rod at the reference generalised vectors v0."""
        if isinstance(rod.material, SaintVenantKirchhoff):
            return (QuadraticTerm(self._stiffness(rod, v0)),)
        return section_terms(self.element, rod, v0)

    def section_point(self, at: float, before: bool = False) -> SectionPoint:
        """The section at the fraction `at` of the reference length.

        On an element boundary the element after it is taken, or the one `before`; only r_x can differ.
        """
        x = at * self.rod.length
        breaks = self.mesh.breaks
        found = np.searchsorted(
            breaks, x * (1.0 - 1e-12) if before else x, side="left" if before else "right"
        )
        index = min(max(int(found) - 1, 0), len(breaks) - 2)
        h = breaks[index + 1] - breaks[index]
        xi = min(max(float(2.0 * (x - breaks[index]) / h - 1.0), -1.0), 1.0)
        N, N_x = _shapes(self.element, xi, float(h))
        d0 = N @ self.e0[index]
        W = np.zeros_like(d0)  # without section vectors there is no rotation to weigh
        if self.element.has_section:
            W = director_weights(self.element, self.rod.section_at(at), d0)
        return SectionPoint(self.dofs[index], N, N_x, d0, W)

    def node_at(self, at: float) -> int:
        """The node nearest to a fraction of the reference length."""
        return int(np.argmin(np.abs(self.mesh.node_x - at * self.rod.length)))

    def node_supports(self) -> list[NodeSupport]:
        """Supports of the rod on its nodes."""
        per_node = 3 * len(self.element.vectors)
        found = []
        for support in self.rod.supports:
            node = self.node_at(support.at)
            _, frame = reference_axis(np.array([support.at * self.rod.length]), self.rod.curvature)
            rows = support_rows(support.kind, self.element, self.rod.base.rotation @ frame[0])
            found.append(NodeSupport(self.first_dof + node * per_node + np.arange(per_node), rows))
        return found

    def nodal(self, q: Floats) -> Floats:
        """Nodal vectors (n_nodes, vectors, 3) of the rod in the model's coordinates q (n,)."""
        return q[self.first_dof : self.first_dof + self.size].reshape(self.q0.shape)

    def element_vectors(self, q: Floats) -> Floats:
        """Nodal vectors per element (..., n_el, nodal, 3) in the model's coordinates q (..., n)."""
        return q[..., self.dofs].reshape(*q.shape[:-1], len(self.dofs), -1, 3)

    def generalised(self, q: Floats) -> Floats:
        """Generalised vectors v (..., n_el, points, generalised vectors, 3) at the axial points."""
        return self.elastic.generalised(self.element_vectors(q))[..., : self.axial_points, :, :]

    def strain_products(self, q: Floats) -> Floats:
        """Strain products gamma (n_el, points, pairs) that the sections see at the axial points."""
        return self.elastic.gamma(self.elastic.generalised(self.element_vectors(q)))

    def section_force(self, q: Floats) -> Floats:
        """Stress of the sections on v per length (n_el, points, generalised vectors, 3)."""
        Q_v = self.elastic.section_force(self.elastic.generalised(self.element_vectors(q)))
        return Q_v / self.axial_weights[..., None, None]

    @property
    def bending_stiffness(self) -> float:
        """Smaller principal E I [N m2], the scale of forces, moments and energy.

        Along a rod that changes its mean is L / int dx/(E I), so that a couple M on the end turns it by
        M L/(E I) as it would a plain rod: the unit of moments is the one that turns the end by a radian.
        """
        rod = self.rod
        if not rod.segments:
            return rod.material.young_modulus * rod.section.weaker_second_moment
        return rod.length / sum(segment.bending_compliance for segment in rod.parts)


@lru_cache(maxsize=256)
def _shapes(element: Element, xi: float, h: float) -> tuple[Floats, Floats]:
    """N and N_x (directors, nodal) at one place; every scene with this element length shares them."""
    found = [element.shape(np.array([xi]), h, derivative)[0] for derivative in (0, 1)]
    for values in found:
        values.setflags(write=False)
    return found[0], found[1]


def _spread(values: Floats, kind: Indices) -> Floats:
    """Values (kinds, ...) for each element (n_el, ...); one kind serves all as (1, ...)."""
    return values if len(values) == 1 else values[kind]


def _piece(elastic: ElasticRod, run: slice) -> ElasticRod:
    """The kernel of a run of alike elements."""
    control = None if elastic.control is None else replace(elastic.control, e0=elastic.control.e0[run])
    return replace(elastic, e0=elastic.e0[run], control=control)


def _relative(element: Element, e: Floats) -> Floats:
    """Nodal vectors with positions relative to the first node, as in the elastic kernel."""
    relative = e.copy()
    columns = np.arange(len(e)) % len(element.vectors) == element.vectors.index(R)
    relative[columns] -= e[element.vectors.index(R)]
    return relative


def make_rod_model(scene: Scene, rod: Rod, first_dof: int) -> RodModel:
    """Mesh a rod of a scene and lay out its reference."""
    element = ELEMENTS[rod.element]
    mesh = make_mesh(element, rod_breaks(scene, rod))
    return RodModel(rod, element, mesh, reference_nodes(rod, element, mesh.node_x), first_dof)
