r"""ANCF beam elements as descriptors: an element is its nodes and its nodal vectors.

The position of a material point is

    r(x, y, z) = sum_k phi_k(y, z) d_k(x),     phi = 1, y, z, ...

with one *director* d_k(x) per section monomial; d_0 is the centre line, d_1 = r_y, d_2 = r_z on the axis.
A nodal vector is a derivative of r by (x, y, z) at a node on the axis; those with the same (y, z) orders
interpolate one director along x (Lagrange, or Hermite where x-derivatives are among them).

Symbols
-------
xi      element coordinate along the axis, -1 to 1;  h element length [m];  x = h (1 + xi)/2
N       axial shape functions, (directors, nodal vectors of the element)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import factorial, sqrt

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Order = tuple[int, int, int]

GAUSS_2 = 1.0 / sqrt(3.0)  # two-point Gauss rule, where quadratic and cubic axes have their best slopes

R: Order = (0, 0, 0)
R_X: Order = (1, 0, 0)
R_Y: Order = (0, 1, 0)
R_Z: Order = (0, 0, 1)
R_XX: Order = (2, 0, 0)
R_YY: Order = (0, 2, 0)
R_YZ: Order = (0, 1, 1)
R_ZZ: Order = (0, 0, 2)


@dataclass(frozen=True)
class Element:
    """One ANCF beam element in the digital nomenclature (dimension, nodes, vectors per node, components).

    Parameters
    ----------
    node_xi : positions of the nodes on the axis, -1 to 1
    vectors : derivative orders (x, y, z) of the vectors that each node carries
    axial_points : Gauss points along the axis for the strain energy by default; fewer leave zero-energy modes
    full_points : Gauss points that integrate the Saint Venant-Kirchhoff energy of a straight element exactly
    locks_from : with this many axial points or more, slender rods lock in bending (curvature-thickness)
    formulations : the formulations that the element knows, its default first (section_energy.py)
    assumed : strains that the default axial rule samples elsewhere on the axis, -1 to 1, than at its points
        (assumed_strain.py); other rules take every strain at their points
    long_from : length in radii of gyration from which on the default axial rule needs what its points miss of
        the sections (hourglass.py); 0: never
    """

    name: str
    node_xi: tuple[float, ...]
    vectors: tuple[Order, ...]
    axial_points: int
    full_points: int
    locks_from: int
    formulations: tuple[str, ...] = ("enhanced", "continuum")
    assumed: tuple[tuple[str, tuple[float, ...]], ...] = ()
    long_from: float = 0.0

    def __hash__(self) -> int:
        """By the name: elements are keys of tables that every solve looks up."""
        return hash(self.name)

    @cached_property
    def directors(self) -> tuple[tuple[int, int], ...]:
        """Section monomials (power of y, power of z) in the order in which the vectors name them."""
        return tuple(dict.fromkeys((j, k) for _, j, k in self.vectors))

    @cached_property
    def generalised(self) -> tuple[Order, ...]:
        """Derivatives (x, y, z) of r on the axis, on whose products the energy of a section depends.

        Slopes of all directors, the directors but the axis; without section vectors r_x and r_xx.
        """
        if not self.has_section:
            return (R_X, R_XX)
        slopes = [(1, j, k) for j, k in self.directors]
        return (*slopes, *((0, j, k) for j, k in self.directors[1:]))

    @cached_property
    def y_director(self) -> int:
        """Which director is r_y on the axis."""
        return self.directors.index((1, 0))

    @cached_property
    def z_director(self) -> int:
        """Which director is r_z on the axis."""
        return self.directors.index((0, 1))

    @cached_property
    def section_degree(self) -> int:
        """Degree in (y, z) of the Saint Venant-Kirchhoff energy density over a straight section.

        Directors of degree p make strains of degree 2 p and their squares of degree 4 p.
        """
        return 4 * max(j + k for j, k in self.directors)

    @property
    def quadratic_section(self) -> bool:
        """Whether sections can show the in-plane field of bending (all directors of second degree)."""
        return {(2, 0), (1, 1), (0, 2)} <= set(self.directors)

    @property
    def has_section(self) -> bool:
        """Whether nodes carry section vectors; without them the element is an axis, a cable."""
        return len(self.directors) > 1

    @property
    def linear_section(self) -> bool:
        """Whether the position is linear in (y, z): every director of first degree."""
        return all(j + k <= 1 for j, k in self.directors)

    @property
    def warps(self) -> bool:
        """Whether sections can warp by y z, as ellipses do in torsion."""
        return (1, 1) in self.directors

    @property
    def vectors_per_element(self) -> int:
        """Number of nodal vectors of one element, 8 for 3243."""
        return len(self.node_xi) * len(self.vectors)

    def shape(self, xi: Floats, h: float, derivative: int = 0) -> Floats:
        """Axial shape functions N or their derivative by x.

        For each director the interpolation conditions at the nodes are inverted once (confluent Vandermonde).

        Parameters
        ----------
        xi : (n,) [-]
        h : element length [m]
        derivative : order of the derivative by x

        Returns
        -------
        (n, directors, nodal vectors of the element), node-major; [m^(orders)].
        """
        coefficients, x_orders = self._interpolation
        xi = np.atleast_1d(np.asarray(xi, dtype=float))
        powers = np.stack([_monomial(p, derivative, xi) for p in range(len(coefficients))], axis=-1)
        scale = (2.0 / h) ** (derivative - x_orders)
        return np.tensordot(powers, coefficients, axes=1) * scale

    @cached_property
    def _interpolation(self) -> tuple[Floats, Floats]:
        """Coefficients (powers of xi, directors, nodal vectors), and the x-order of each nodal vector."""
        per_node, nodes = len(self.vectors), len(self.node_xi)
        x_orders = np.tile([float(i) for i, _, _ in self.vectors], nodes)
        blocks = []
        for monomial in self.directors:
            local = [v for v, (_, j, k) in enumerate(self.vectors) if (j, k) == monomial]
            conditions = [(node, v) for node in range(nodes) for v in local]
            matrix = np.array(
                [
                    [
                        _monomial(p, self.vectors[v][0], np.array(self.node_xi[node]))
                        for p in range(len(conditions))
                    ]
                    for node, v in conditions
                ],
                dtype=float,
            )
            blocks.append(([node * per_node + v for node, v in conditions], np.linalg.inv(matrix)))
        highest = max(len(columns) for columns, _ in blocks)
        coefficients = np.zeros((highest, len(blocks), per_node * nodes))
        for director, (columns, inverse) in enumerate(blocks):
            coefficients[: len(columns), director, columns] = inverse
        return coefficients, x_orders

    @cached_property
    def _powers(self) -> tuple[NDArray[np.intp], NDArray[np.intp], Floats]:
        """Powers j of y and k of z of the section monomials, and 1/(j! k!)."""
        j, k = np.array(self.directors).T
        return j, k, 1.0 / np.array([factorial(a) * factorial(b) for a, b in self.directors])

    def section_monomials(self, y: Floats, z: Floats) -> tuple[Floats, Floats, Floats]:
        """phi_k = y^j z^k/(j! k!) and its derivatives by y and z, each (n, directors)."""
        y, z = np.broadcast_arrays(np.atleast_1d(np.asarray(y, float)), np.asarray(z, float))
        j, k, weight = self._powers
        y, z = y[:, None], z[:, None]
        phi = weight * y**j * z**k
        phi_y = weight * j * y ** np.maximum(j - 1, 0) * z**k
        phi_z = weight * k * y**j * z ** np.maximum(k - 1, 0)
        return phi, phi_y, phi_z


def _monomial(power: int, derivative: int, xi: Floats) -> Floats:
    """The derivative of xi^power of the given order."""
    if derivative > power:
        return np.zeros_like(xi, dtype=float)
    return factorial(power) / factorial(power - derivative) * xi ** (power - derivative)


# 3243: cubic Hermite axis, linear section vectors. Two axial points leave spurious zero modes, three lock
# mildly.
# 3333: quadratic axis and section vectors. Two points remove curvature-thickness, shear and membrane locking.
# 3343: 3333 with r_yz, by which rectangles warp in torsion. Strains of the section at the nodes remove what
# is left of curvature-thickness locking: an order of magnitude less error than 3333 at the same mesh.
# Sections that can warp may swell between two points almost for nothing, hence the control (hourglass.py).
# 3363: 3343 with quadratic sections, which show the in-plane field of bending: the continuum without locking.
# cable: cubic Hermite axis alone. With its strain taken at the nodes, which neighbours share, and in the
# middle it can bend without stretching; its curvature is best at two Gauss points; three points leave no mode
# free.
ELEMENTS: dict[str, Element] = {
    "3333": Element("3333", (-1.0, 0.0, 1.0), (R, R_Y, R_Z), axial_points=2, full_points=5, locks_from=3),
    "3243": Element("3243", (-1.0, 1.0), (R, R_X, R_Y, R_Z), axial_points=3, full_points=5, locks_from=3),
    "3343": Element(
        "3343",
        (-1.0, 0.0, 1.0),
        (R, R_Y, R_Z, R_YZ),
        axial_points=2,
        full_points=5,
        locks_from=3,
        assumed=(("section", (-1.0, 0.0, 1.0)),),
        long_from=12.0,
    ),
    "3363": Element(
        "3363",
        (-1.0, 0.0, 1.0),
        (R, R_Y, R_Z, R_YY, R_YZ, R_ZZ),
        axial_points=2,
        full_points=5,
        locks_from=3,
        formulations=("continuum",),
        assumed=(("section", (-1.0, 0.0, 1.0)),),
        long_from=8.0,
    ),
    "cable": Element(
        "cable",
        (-1.0, 1.0),
        (R, R_X),
        axial_points=3,
        full_points=5,
        locks_from=3,
        formulations=("enhanced",),
        assumed=(("axial", (-1.0, 0.0, 1.0)), ("curvature", (-GAUSS_2, GAUSS_2))),
    ),
}

# Those that know how their sections stand: what turns, twists or strains a section asks for one of them.
SECTION_ELEMENTS: dict[str, Element] = {
    name: element for name, element in ELEMENTS.items() if element.has_section
}
