"""One rod as arrays: mesh, reference vectors, elastic kernel data and section points for loads.

Symbols
-------
q0       reference nodal vectors of the rod (n_nodes, vectors, 3), positions relative to the base
dofs     unknowns of the model that belong to an element (n_el, 3 nodal)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.elements import ELEMENTS, Element, R
from ancf.energy import ElasticRod
from ancf.materials import SaintVenantKirchhoff
from ancf.mesh import Mesh, make_mesh, reference_axis, reference_nodes, rod_breaks
from ancf.quadrature import gauss
from ancf.scene import Rod, Scene
from ancf.section_energy import (
    director_weights,
    generalised_shape,
    section_stiffness,
    section_terms,
    straight_reference,
    straight_section_stiffness,
)
from ancf.section_law import AlikeSections, QuadraticSection, QuadratureSection
from ancf.supports import NodeSupport, support_rows

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


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
    def element_kinds(self) -> tuple[Indices, Indices]:
        """One element of each length, and for every element the kind it belongs to.

        Curvature is constant along a rod, so elements of one length are the same up to a rigid motion.
        """
        # Lengths that differ by rounding only are equal: compare 12 digits.
        relative = np.round(self.mesh.h / self.rod.length, 12)
        _, first, kind = np.unique(relative, return_index=True, return_inverse=True)
        return first, kind

    @cached_property
    def elastic(self) -> ElasticRod:
        """Constant data of the elastic kernel; equal elements share their data."""
        first, kind = self.element_kinds
        xi, _ = gauss(self.axial_points)
        N = np.array([generalised_shape(self.element, xi, float(self.mesh.h[index])) for index in first])
        per_node, nodes = len(self.element.vectors), len(self.element.node_xi)
        columns = np.arange(nodes) * per_node + self.element.vectors.index(R)
        v0 = [shape @ _relative(self.element, self.e0[index]) for shape, index in zip(N, first, strict=True)]
        if isinstance(self.rod.material, SaintVenantKirchhoff):
            H = [[self._stiffness(v) for v in points] for points in v0]
            weight = self.axial_weights[first][..., None, None]
            section = QuadraticSection(_spread(weight * np.array(H), kind))
        else:
            section = QuadratureSection(self._groups(v0))
        return ElasticRod(_spread(N, kind), section, self.e0, columns)

    def _stiffness(self, v0: Floats) -> Floats:
        rod = self.rod
        if np.any(rod.curvature):
            return section_stiffness(self.element, rod, v0)
        assert isinstance(rod.material, SaintVenantKirchhoff)
        return straight_section_stiffness(
            self.element, rod.section, rod.material, rod.formulation, rod.shear_factors
        )

    def _groups(self, v0: list[Floats]) -> tuple[AlikeSections, ...]:
        """Alike sections: all of a straight rod, else one axial point of one kind of element."""
        weight = self.axial_weights.ravel()
        places = np.arange(len(weight)).reshape(self.axial_weights.shape)
        if not np.any(self.rod.curvature):
            terms = section_terms(self.element, self.rod, straight_reference(self.element))
            return (AlikeSections(places.ravel(), weight, terms),)
        _, kind = self.element_kinds
        groups = []
        for row, points in enumerate(v0):
            for point, v in enumerate(points):
                alike = places[kind == row, point]
                groups.append(AlikeSections(alike, weight[alike], section_terms(self.element, self.rod, v)))
        return tuple(groups)

    def section_point(self, at: float, before: bool = False) -> SectionPoint:
        """The section at the fraction `at` of the reference length.

        On an element boundary the element after it is taken, or the one `before`; only r_x can differ.
        """
        x = at * self.rod.length
        breaks = self.mesh.breaks
        found = np.searchsorted(
            breaks, x * (1.0 - 1e-12) if before else x, side="left" if before else "right"
        )
        index = int(np.clip(found - 1, 0, len(breaks) - 2))
        h = breaks[index + 1] - breaks[index]
        xi = np.clip(np.array([2.0 * (x - breaks[index]) / h - 1.0]), -1.0, 1.0)
        N, N_x = self.element.shape(xi, h)[0], self.element.shape(xi, h, derivative=1)[0]
        d0 = N @ self.e0[index]
        return SectionPoint(
            self.dofs[index], N, N_x, d0, director_weights(self.element, self.rod.section, d0)
        )

    def node_supports(self) -> list[NodeSupport]:
        """Supports of the rod on its nodes."""
        per_node = 3 * len(self.element.vectors)
        found = []
        for support in self.rod.supports:
            x = support.at * self.rod.length
            node = int(np.argmin(np.abs(self.mesh.node_x - x)))
            _, frame = reference_axis(np.array([x]), self.rod.curvature)
            rows = support_rows(support.kind, self.element, self.rod.base.rotation @ frame[0])
            found.append(NodeSupport(self.first_dof + node * per_node + np.arange(per_node), rows))
        return found

    def nodal(self, q: Floats) -> Floats:
        """Nodal vectors (n_nodes, vectors, 3) of the rod in the model's coordinates q (n,)."""
        return q[self.first_dof : self.first_dof + self.size].reshape(self.q0.shape)

    def element_vectors(self, q: Floats) -> Floats:
        """Nodal vectors per element (n_el, nodal, 3) in the model's coordinates q (n,)."""
        return q[self.dofs].reshape(len(self.dofs), -1, 3)

    def generalised(self, q: Floats) -> Floats:
        """Generalised vectors v (n_el, points, generalised vectors, 3) at the axial points."""
        return self.elastic.generalised(self.element_vectors(q))

    @property
    def bending_stiffness(self) -> float:
        """Smaller principal E I [N m2], the scale of forces, moments and energy."""
        return self.rod.material.young_modulus * self.rod.section.weaker_second_moment


def _spread(values: Floats, kind: Indices) -> Floats:
    """Values (kinds, ...) for each element (n_el, ...); one kind serves all as (1, ...)."""
    return values if len(values) == 1 else values[kind]


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
