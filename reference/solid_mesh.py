"""Hexahedral mesh of a straight rod: a curved quadratic section mesh, extruded along X.

Symbols: `X` reference position, x along the axis, y and z across; `n` core quads per side;
`ns` nodes of one section; `plane` a set of nodes with equal X (two planes per slice).
The nodes are numbered plane by plane, so every matrix on this mesh is block tridiagonal.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, BilinearForm, ElementQuad2, MeshHex, MeshHex2, MeshQuad, MeshQuad2

Array = NDArray[np.float64]

CORE_HALF_SIDE = 0.5  # of the radius; 0.4 to 0.6 give the same bending answer within 1e-4
SECTION_ORDER = 7  # exact for phi_a phi_b det J on 9-node quads: degree 4 + 3 in each direction
CENTRE_TOLERANCE = 1e-9  # of the largest radius
MATCH_DIGITS = 9  # nodes of the section and of the rod are matched in exact grid coordinates


@dataclass(frozen=True, eq=False)
class SectionMesh:
    """A cross-section of 9-node quads with its mass matrix.

    `grid` (4-node quads on a plain grid) carries the topology, `grid_nodes` (ns, 2) [-] the nodes on it,
    `nodes` (ns, 2) [m] the same nodes in the section (y, z), `quads` (n_quad, 9) their numbers in the order
    of scikit-fem's `ElementQuad2`, `mass` (ns, ns) [m^2] int phi_a phi_b dA, `centre` the node on the axis,
    None where the section is hollow, `rim` the nodes of the outer rim on +y, +z, -y, -z.
    """

    grid: MeshQuad
    grid_nodes: Array
    nodes: Array
    quads: NDArray[np.int64]
    mass: Array
    centre: int | None
    rim: list[int]

    @property
    def area(self) -> float:
        """Discrete area, int dA [m^2]."""
        return float(self.mass.sum())

    @property
    def second_moments(self) -> Array:
        """Discrete second moments, int X_i X_j dA (2, 2) [m^4] about the origin."""
        return self.nodes.T @ self.mass @ self.nodes


@dataclass(frozen=True, eq=False)
class RodMesh:
    """A straight rod of 27-node hexahedra from x = 0 to x = length.

    Node `plane * ns + a` is section node `a` in that plane. `nodes` (n, 3) [m]; `elements` (n_el, 27) in the
    order of scikit-fem's `ElementHex2`; `hexes` the same mesh for scikit-fem, whose own node order is
    `order`: `hexes.doflocs[:, order].T == nodes`.
    """

    section: SectionMesh
    length: float
    slices: int
    nodes: Array
    elements: NDArray[np.int64]
    hexes: MeshHex2
    order: NDArray[np.int64]

    @property
    def plane_positions(self) -> Array:
        """Reference x of every plane (2 slices + 1,) [m]."""
        return np.linspace(0.0, self.length, 2 * self.slices + 1)

    def plane(self, index: int) -> NDArray[np.int64]:
        """Nodes (ns,) of one plane; 0 is the start face, -1 the end face."""
        ns = len(self.section.nodes)
        return np.arange(ns) + ns * range(2 * self.slices + 1)[index]


def circular_section(radius: float, core: int = 2, rings: int = 1, *, match_I: bool = True) -> SectionMesh:
    """Disc as an O-grid: a square core of `core` x `core` quads inside `rings` rings of curved quads.

    With `match_I` all nodes are scaled so that the discrete second moment is pi radius^4/4 exactly:
    unscaled quadratic arcs miss it by -1.6e-3 at core 2, more than every other error of the mesh
    (reference study). The area then errs by some 1e-7.
    """
    return elliptic_section(radius, radius, core, rings, match_I=match_I)


def elliptic_section(
    semi_axis_y: float, semi_axis_z: float, core: int = 2, rings: int = 1, *, match_I: bool = True
) -> SectionMesh:
    """Ellipse as the affine image of the disc of `circular_section`.

    Second moments pi a^3 b/4 and pi a b^3/4 exactly with `match_I`, which an affine map keeps.
    """
    _check_sizes({"semi_axis_y": semi_axis_y, "semi_axis_z": semi_axis_z}, {"core": core, "rings": rings})
    semi_axes = np.array([semi_axis_y, semi_axis_z])
    I_y = np.pi / 4 * semi_axis_y**3 * semi_axis_z if match_I else None
    return _matched_section(_o_grid(core, rings), lambda p: semi_axes * _disc_from_square(p), I_y)


def annular_section(
    radius: float, inner_radius: float, quarter: int = 2, rings: int = 1, *, match_I: bool = True
) -> SectionMesh:
    """Ring of `rings` layers with `quarter` curved quads on each quarter of the circumference.

    With `match_I` the discrete second moment is pi (radius^4 - inner_radius^4)/4 exactly. There is no node
    on the axis: `centre` is None, and a section is located by its area mean.
    """
    _check_sizes({"radius": radius, "inner_radius": inner_radius}, {"quarter": quarter, "rings": rings})
    if not inner_radius < radius:
        raise ValueError(
            f"inner_radius is {inner_radius} m, radius {radius} m: the wall has no thickness. "
            "Give an inner radius below the outer one; `circular_section` has no hole."
        )
    grid = _o_grid(quarter, rings, filled=False)

    def ring(p: Array) -> Array:
        size = np.max(np.abs(p), axis=1)[:, None]
        return (inner_radius + (size - 1) * (radius - inner_radius)) * _arc_from_square(p / size)

    I_y = np.pi / 4 * (radius**4 - inner_radius**4) if match_I else None
    return _matched_section(grid, ring, I_y)


def rectangular_section(
    height_y: float, width_z: float, cells_y: int = 2, cells_z: int | None = None
) -> SectionMesh:
    """Rectangle |y| <= height_y/2, |z| <= width_z/2 of `cells_y` x `cells_z` equal quads.

    `cells_z` is `cells_y` unless given. No scaling: straight edges carry the area and the second moments
    exactly. The nodes (0, 0) and (height_y/2, 0) exist for even and odd counts alike.
    """
    cells_z = cells_y if cells_z is None else cells_z
    _check_sizes({"height_y": height_y, "width_z": width_z}, {"cells_y": cells_y, "cells_z": cells_z})
    grid = MeshQuad.init_tensor(np.linspace(-1, 1, cells_y + 1), np.linspace(-1, 1, cells_z + 1))
    return _section_from_grid(grid, lambda p: p * np.array([height_y, width_z]) / 2)


def rod_mesh(section: SectionMesh, length: float, slices: int) -> RodMesh:
    """Extrude a section mesh along x into `slices` layers of 27-node hexahedra of equal length."""
    _check_sizes({"length": length}, {"slices": slices})
    corners, quads = section.grid.p, section.grid.t
    n_corner = corners.shape[1]
    # Corner order of scikit-fem's MeshHex in (x, y, z): 000 001 010 100 011 101 110 111.
    column = np.array([0, 3, 1, 0, 2, 3, 1, 2])
    far = np.array([0, 0, 0, 1, 0, 1, 1, 1])
    layer = quads[column] + n_corner * far[:, None]
    p = np.vstack([np.repeat(np.arange(slices + 1.0), n_corner), np.tile(corners, slices + 1)])
    t = np.hstack([layer + n_corner * k for k in range(slices)])
    plain = MeshHex2.from_mesh(MeshHex(np.ascontiguousarray(p), np.ascontiguousarray(t)))

    x, y, z = np.round(plain.doflocs, MATCH_DIGITS)
    ns = len(section.nodes)
    by_position = np.lexsort((z, y, x)).reshape(2 * slices + 1, ns)
    order = np.empty_like(by_position)
    order[:, np.lexsort(np.round(section.grid_nodes.T[::-1], MATCH_DIGITS))] = by_position
    order = order.ravel()

    planes = np.linspace(0.0, length, 2 * slices + 1)
    nodes = np.column_stack([np.repeat(planes, ns), np.tile(section.nodes, (2 * slices + 1, 1))])
    doflocs = np.empty((3, len(nodes)))
    doflocs[:, order] = nodes.T
    hexes = MeshHex2(doflocs, plain.t)
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    return RodMesh(section, length, slices, nodes, number[hexes.dofs.element_dofs.T], hexes, order)


def _check_sizes(sizes: dict[str, float], counts: dict[str, int]) -> None:
    """Refuse sizes that are not positive and finite, and counts below 1."""
    for name, size in sizes.items():
        if not (size > 0 and np.isfinite(size)):
            raise ValueError(f"{name} is {size} m; it must be positive and finite.")
    for name, count in counts.items():
        if count < 1:
            raise ValueError(f"{name} is {count}; at least 1 is needed.")


def _o_grid(core: int, rings: int, *, filled: bool = True) -> MeshQuad:
    """O-grid in the square |p| <= 2 (maximum norm): the core is |p| <= 1 (if filled), the rings outside."""
    line = np.linspace(-1.0, 1.0, core + 1)
    points = [np.array([y, z]) for z in line for y in line]
    quads = [
        [j * (core + 1) + i, j * (core + 1) + i + 1, (j + 1) * (core + 1) + i + 1, (j + 1) * (core + 1) + i]
        for j in range(core)
        for i in range(core)
    ]
    row = core + 1
    loop = [*range(core), *(core + row * j for j in range(core))]
    loop += [*(row * core + i for i in range(core, 0, -1)), *(row * j for j in range(core, 0, -1))]
    rim = np.array([points[k] for k in loop])
    inner = np.array(loop)
    for ring in range(1, rings + 1):
        outer = len(points) + np.arange(len(loop))
        points.extend((1 + ring / rings) * rim)
        quads += np.stack([inner, outer, np.roll(outer, -1), np.roll(inner, -1)], axis=1).tolist()
        inner = outer
    used, t = np.unique(np.array(quads if filled else quads[core**2 :]), return_inverse=True)
    return MeshQuad(np.ascontiguousarray(np.array(points)[used].T), np.ascontiguousarray(t.reshape(-1, 4).T))


def _disc_from_square(p: Array) -> Array:
    """Map O-grid coordinates (n, 2) to the unit disc: straight core, arcs of equal angle on the rim."""
    size = np.max(np.abs(p), axis=1)
    q = p / np.maximum(size, 1.0)[:, None]  # on the core's border for points outside it
    s = np.maximum(size - 1.0, 0.0)[:, None]
    return (1 - s) * CORE_HALF_SIDE * q + s * _arc_from_square(q)


def _arc_from_square(q: Array) -> Array:
    """Points (n, 2) of the unit circle at equal angles from points on the square |q| = 1 (maximum norm)."""
    y, z = q.T
    return np.where(
        np.abs(y) >= np.abs(z),
        [np.copysign(np.cos(z * np.pi / 4), y), np.sin(z * np.pi / 4)],
        [np.sin(y * np.pi / 4), np.copysign(np.cos(y * np.pi / 4), z)],
    ).T


def _matched_section(grid: MeshQuad, section_map: Callable[[Array], Array], I_y: float | None) -> SectionMesh:
    """Section of a curved outline, scaled about its centre until int y^2 dA is `I_y` [m^4] if given."""
    section = _section_from_grid(grid, section_map)
    if I_y is None:
        return section
    scale = (I_y / section.second_moments[0, 0]) ** 0.25
    return _section_from_grid(grid, lambda p: scale * section_map(p))


def _section_from_grid(grid: MeshQuad, section_map: Callable[[Array], Array]) -> SectionMesh:
    """Section mesh whose nodes are the images of the 9-node grid under `section_map`."""
    plain = MeshQuad2.from_mesh(grid)
    grid_nodes = plain.doflocs.T
    nodes = section_map(grid_nodes)
    basis = Basis(MeshQuad2(np.ascontiguousarray(nodes.T), plain.t), ElementQuad2(), intorder=SECTION_ORDER)
    mass = BilinearForm(lambda u, v, w: u * v).assemble(basis).toarray()
    distance = np.linalg.norm(nodes, axis=1)
    nearest = int(np.argmin(distance))
    centre = nearest if distance[nearest] < CENTRE_TOLERANCE * distance.max() else None
    y, z = nodes.T
    rim = [int(np.argmax(along - np.abs(across))) for along, across in [(y, z), (z, y), (-y, z), (-z, y)]]
    return SectionMesh(grid, grid_nodes, nodes, basis.element_dofs.T, mass, centre, rim)
