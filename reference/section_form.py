"""Energy of one section of a bar in uniform bending, twist and extension, on the quads of its mesh.

A bar whose strain is the same at every section moves as a screw: x(s, Y) = r(s) + S(s) u(Y), S' = S hat(k),
r' = S a. In the frame S, with the material turning by the angle spin s about its own axis (circles only),

    F = [ a + k x u + spin (y du/dz - z du/dy) | du/dy | du/dz ],    U(u, e) = int_A Psi(F) dA.

Symbols: `u` (ns, 3) position of the section's points from its mean point; `e` (7,) = (a, k, spin) strain of
the bar; `q` (7,) = dU/de = (force, couple, spin force). The frame is that of the section itself: C u = 0 says
that the mean of u is zero and that the polar rotation of int u Y^T dA is the identity, which is linear in u.
Everything is without unit: lengths by `size`, stresses by Young's modulus.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array

from reference.rotation import cross, hat
from reference.section_points import shapes_at
from reference.section_shapes import SectionShapes
from reference.solid_materials import SolidMaterial
from reference.solid_mesh import SectionMesh

Array = NDArray[np.float64]

STRAINS = 7
DEPENDENT = 1e-10  # of the largest singular value: polynomials that differ by less are one
ROUND_OFF = 1e-14  # smallest strain that arithmetic resolves, times 1 + lambda/mu


@dataclass(frozen=True, eq=False)
class SectionForces:
    """Energy, gradient (3 n + 7,) and second derivative (square, sparse) of one state.

    `pressure` (n_el, n_qp) and `pressure_rates` (n_el, n_qp, n_b 3 + 7) are Pi U' and its derivative by the
    unknowns of each element, empty when not mixed.
    """

    energy: float
    gradient: Array
    tangent: csc_array
    pressure: Array
    pressure_rates: Array


@dataclass(frozen=True, eq=False)
class StressField:
    """Stress at points, (n_el, n_qp, ...) those of integration or (n, ...) others, in the section's frame.

    `points` (..., 2) [m] in the undeformed section, `weights` [m^2], `F`, `pk1` and `cauchy` (..., 3, 3).
    """

    points: Array
    weights: Array
    F: Array
    pk1: Array
    cauchy: Array


class SectionForm:
    """Discrete energy of a section.

    Parameters
    ----------
    section : SectionMesh
        Any section; its coordinates are counted from its mean point.
    material : SolidMaterial
        The law.
    mixed : bool
        Energy of the volume on the projection of its measure, element by element, to the polynomials of
        degree order - 1 in (y, z): no locking as nu -> 1/2, same unknowns, symmetric.
    order : int
        2 is the element of the solid (Q2, and Q2/P1 when mixed); 4 holds the quadratic lateral field of
        bending on the curved quads exactly. The edge of the section stays that of the mesh.
    """

    def __init__(self, section: SectionMesh, material: SolidMaterial, mixed: bool, order: int) -> None:
        self.section, self.material, self.mixed = section, material, mixed
        self.size = float(np.sqrt(section.area / np.pi))
        self.stress_unit = material.young_modulus
        self.shapes = SectionShapes(section, self.size, order)
        self.elements, self.weights = self.shapes.elements, self.shapes.weights
        self.phi, self.phi_y, self.phi_z = self.shapes.phi, self.shapes.phi_y, self.shapes.phi_z
        self.Y = self.shapes.coordinates
        y, z = self.shapes.points[..., :1], self.shapes.points[..., 1:]
        self.phi_spin = y * self.phi_z - z * self.phi_y
        if mixed:
            self.moments, self.projection = self._projection()
        n, n_el = self.Y.size // 2 * 3, len(self.elements)
        nodal = (3 * self.elements[..., None] + np.arange(3)).reshape(n_el, -1)
        self.local = nodal.shape[1]  # unknowns of an element without those of the bar
        strains = np.broadcast_to(n + np.arange(STRAINS), (n_el, STRAINS))
        self.slots = np.concatenate([nodal, strains], axis=1)
        self.unknowns = n + STRAINS
        self.frame = self._frame()

    @property
    def straight(self) -> tuple[Array, Array]:
        """Undeformed state: u = Y (ns, 3) and e = (1, 0, ..., 0)."""
        u = np.column_stack([np.zeros(len(self.Y)), self.Y])
        return u, np.eye(STRAINS)[0]

    @property
    def round_off(self) -> float:
        """Smallest strain, and force by E size^2, that arithmetic resolves."""
        return ROUND_OFF * (1 + self.material.lame_lambda / self.material.lame_mu)

    def deformation_gradient(self, u: Array, e: Array) -> Array:
        """Deformation gradient F (n_el, n_qp, 3, 3) [-] of the module's formula."""
        nodes = u[self.elements][:, None]
        first = e[:3] + cross(e[3:6], self._at(self.phi, nodes)) + e[6] * self._at(self.phi_spin, nodes)
        return np.stack([first, self._at(self.phi_y, nodes), self._at(self.phi_z, nodes)], axis=-1)

    def stress(self, F: Array) -> Array:
        """First Piola-Kirchhoff stress by Young's modulus, P = dPsi_shape/dF + Pi(U') dg/dF when mixed."""
        if not self.mixed:
            return self.material.stress(F) / self.stress_unit
        g, g_F, _ = self.material.volume_measure(F)
        pressure = self._project(self.material.volume_energy(self._project(g))[1])
        return (self.material.shape.stress(F) + pressure[..., None, None] * g_F) / self.stress_unit

    def forces(self, u: Array, e: Array, predicted: Array | None = None) -> SectionForces:
        """Energy, gradient and second derivative in (u, e) at one state with det F > 0.

        `predicted` (n_el, n_qp) [Pa] replaces the pressure in the second derivative only: the pressure that
        the last linear step foresaw makes Newton's method that of displacement and pressure together, which
        does not stumble over lambda >> mu (mixed integration point; Magisano, Leonetti, Garcea 2017).
        """
        law, unit = self.material, self.stress_unit
        F = self.deformation_gradient(u, e)
        B = self._strain_matrix(u, e)
        (n_el, n_qp), n = self.weights.shape, self.local
        if self.mixed:
            g, g_F, g_FF = law.volume_measure(F)
            U, U_1, U_2 = law.volume_energy(self._project(g))
            pressure = self._project(U_1)
            if predicted is None:
                predicted = pressure
            density = law.shape.energy(F) + U
            P_shape = law.shape.stress(F)
            P = P_shape + pressure[..., None, None] * g_F
            P_tangent = P_shape + predicted[..., None, None] * g_F
            A = law.shape.tangent(F) + predicted[..., None, None, None, None] * g_FF
            rates = self.projection @ (g_F.reshape(n_el, n_qp, 1, 9) @ B)[:, :, 0]
            pressure_rates = U_2[..., None] * rates
            K = rates.swapaxes(1, 2) @ (pressure_rates * self.weights[..., None]) / unit
        else:
            density, P, A = law.energy(F), law.stress(F), law.tangent(F)
            P_tangent, pressure, pressure_rates = P, np.zeros(0), np.zeros(0)
            K = np.zeros((n_el, n + STRAINS, n + STRAINS))
        left = (B * self.weights[..., None, None] / unit).reshape(n_el, 9 * n_qp, -1).swapaxes(1, 2)
        K += left @ (A.reshape(n_el, n_qp, 9, 9) @ B).reshape(n_el, 9 * n_qp, -1)
        bend = self._second_variation(P_tangent / unit)
        K[:, :n, n + 3 :] += bend
        K[:, n + 3 :, :n] += bend.swapaxes(1, 2)
        local = (left @ P.reshape(n_el, 9 * n_qp, 1))[..., 0]
        gradient = np.bincount(self.slots.ravel(), local.ravel(), minlength=self.unknowns)
        rows = np.broadcast_to(self.slots[:, :, None], K.shape).ravel()
        columns = np.broadcast_to(self.slots[:, None, :], K.shape).ravel()
        tangent = csc_array(coo_array((K.ravel(), (rows, columns)), shape=(self.unknowns, self.unknowns)))
        energy = float(np.sum(density * self.weights)) / unit
        return SectionForces(energy, np.asarray(gradient, float), tangent, pressure, pressure_rates)

    def predict_pressure(self, forces: SectionForces, step: Array) -> Array | None:
        """Pressure after a linear step (3 n + 7,), Pi (U' + U'' Pi dg) [Pa]; None when not mixed."""
        if not self.mixed:
            return None
        return forces.pressure + self._project((forces.pressure_rates @ step[self.slots][..., None])[..., 0])

    def least_volume(self, u: Array, e: Array) -> float:
        """Least det F of the integration points [-]; a law of rubber needs it positive."""
        return float(np.linalg.det(self.deformation_gradient(u, e)).min())

    def stress_field(self, u: Array, e: Array) -> StressField:
        """Stress of a state at the integration points; Cauchy stress = P F^T/det F [Pa]."""
        F = self.deformation_gradient(u, e)
        points, weights = self.shapes.points * self.size, self.weights * self.size**2
        return _stress_field(points, weights, F, self.stress(F) * self.stress_unit)

    def stress_at(self, u: Array, e: Array, points: Array) -> StressField:
        """Stress of a state at any points (n, 2) [m] of the section; the weights are zero."""
        Y = points / self.size
        quad, phi, phi_y, phi_z = shapes_at(self.shapes, Y)
        nodes = u[self.elements[quad]]
        at, along_y, along_z = (self._at(shape, nodes) for shape in (phi, phi_y, phi_z))
        spun = Y[:, :1] * along_z - Y[:, 1:] * along_y
        F = np.stack([e[:3] + cross(e[3:6], at) + e[6] * spun, along_y, along_z], axis=-1)
        if not self.mixed:
            return _stress_field(points, np.zeros(len(points)), F, self.material.stress(F))
        g = self.material.volume_measure(self.deformation_gradient(u, e))[0]
        pressure = self.moments @ self.material.volume_energy(self._project(g))[1][..., None]
        here = (self._smooth(Y, quad)[:, None] @ pressure[quad])[..., 0]
        P = self.material.shape.stress(F) + here[..., None] * self.material.volume_measure(F)[1]
        return _stress_field(points, np.zeros(len(points)), F, P)

    def nodal_values(self, u: Array) -> Array:
        """Field u (n, 3) at the nodes of the section mesh (ns, 3)."""
        phi, _, _ = self.shapes.at_nodes()
        values = np.empty((len(self.section.nodes), 3))
        values[self.shapes.node_numbers()] = phi @ u[self.elements]
        return values

    def _projection(self) -> tuple[Array, Array]:
        """Values at the points to coefficients of `_smooth` (n_el, n_p, n_qp), and to projected values.

        By singular values, because on a thin curved quad the polynomials are nearly dependent.
        """
        points = self.shapes.points
        self.quad_mean = points.mean(axis=1)
        self.quad_size = np.abs(points - self.quad_mean[:, None]).max(axis=1)
        smooth = self._smooth(points, np.arange(len(points))[:, None])
        root = np.sqrt(self.weights)[..., None]
        left, values, right = np.linalg.svd(root * smooth, full_matrices=False)
        kept = values > DEPENDENT * values[:, :1]
        inverse = np.where(kept, 1.0 / np.where(kept, values, 1.0), 0.0)
        moments = (right.swapaxes(1, 2) * inverse[:, None]) @ (root * left).swapaxes(1, 2)
        left = left * kept[:, None]
        return moments, (left / root) @ (root * left).swapaxes(1, 2)

    def _smooth(self, Y: Array, quad: NDArray[np.intp]) -> Array:
        """Polynomials of degree order - 1 at points Y (..., 2) of quads, that carry the volume when mixed.

        Coordinates are counted from the quad's mean point, by its size along y and z.
        """
        local, order = (Y - self.quad_mean[quad]) / self.quad_size[quad], self.shapes.order
        y, z = local[..., :1], local[..., 1:]
        terms = [y**i * z ** (n - i) for n in range(order) for i in range(n + 1)]
        return np.concatenate(terms, axis=-1)

    @staticmethod
    def _at(shape: Array, nodes: Array) -> Array:
        return (shape[..., None, :] @ nodes)[..., 0, :]

    def _project(self, density: Array) -> Array:
        """L2 projection to the smooth polynomials of every element, at the points (n_el, n_qp)."""
        return (self.projection @ density[..., None])[..., 0]

    def _strain_matrix(self, u: Array, e: Array) -> Array:
        """Derivative of F (9, row by row) by the unknowns of an element (n_el, n_qp, 9, n + 7)."""
        nodes, n = u[self.elements][:, None], self.local
        B = np.zeros((*self.weights.shape, 3, 3, n + STRAINS))
        for i in range(3):
            B[..., i, 0, i:n:3] += e[6] * self.phi_spin
            B[..., i, 1, i:n:3] = self.phi_y
            B[..., i, 2, i:n:3] = self.phi_z
            B[..., i, 0, n + i] = 1.0
            for j in range(3):
                B[..., i, 0, j:n:3] += hat(e[3:6])[i, j] * self.phi
        B[..., :, 0, n + 3 : n + 6] = -hat(self._at(self.phi, nodes))
        B[..., :, 0, n + 6] = self._at(self.phi_spin, nodes)
        return B.reshape(*self.weights.shape, 9, -1)

    def _second_variation(self, P: Array) -> Array:
        """P : d2F, from the products k x u and spin u: rows nodes, columns (k, spin) (n_el, n, 4)."""
        first = P[..., 0] * self.weights[..., None]
        # P_1 . (dk x du) = dk . (du x P_1) = du . (P_1 x dk)
        by_k = np.einsum("eqb,eqij->ebij", self.phi, hat(first))
        by_spin = np.einsum("eqb,eqi->ebi", self.phi_spin, first)
        return np.concatenate([by_k, by_spin[..., None]], axis=-1).reshape(len(P), -1, 4)

    def _frame(self) -> Array:
        """Rows C (6, 3 ns): mean of u; int u_x y, int u_x z, int (u_y z - u_z y), zero in the polar frame."""
        phi = self.shapes.phi * self.weights[..., None]
        C = np.zeros((6, len(self.Y), 3))
        mean, y, z = (self.shapes.gather(phi * c) for c in (1.0, *np.split(self.shapes.points, 2, axis=-1)))
        for i in range(3):
            C[i, :, i] = mean
        C[3, :, 0], C[4, :, 0] = y, z
        C[5, :, 1], C[5, :, 2] = z, -y
        return C.reshape(6, -1)


def _stress_field(points: Array, weights: Array, F: Array, pk1: Array) -> StressField:
    cauchy = pk1 @ F.swapaxes(-1, -2) / np.linalg.det(F)[..., None, None]
    return StressField(points, weights, F, pk1, cauchy)
