"""Small bodies on which the solid reference is checked: prescribed nodes, given nodal loads, a plain Newton.

The solver of the rods is not used: its supports, its couple, its start values and its block solver have their
own tests. What is under test here is the law, the assembly and the form (displacement or mixed).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.linalg import spsolve
from skfem import Basis, ElementHex2, FacetBasis, MeshHex2

from reference.invariant_laws import InvariantLaw
from reference.manufactured import WaveMotion, body_force, traction
from reference.solid_assembly import SolidAssembly
from reference.solid_forms import Formulation, solid_form
from reference.solid_materials import SolidMaterial
from reference.solid_mesh import RodMesh

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

FINE_ORDER = 8  # quadrature of loads and error norms, finer than that of the assembly
TOLERANCE = 1e-11  # of the nodal forces
STALLED = 1e-13  # of the size of the body: a step as small as this is rounding
MAX_ITERATIONS = 30
MAX_HALVINGS = 12


class NoEquilibrium(RuntimeError):
    """A check could not be measured because its body found no equilibrium."""


class Body:
    """A mesh with a law, a form and the prescribed components `fixed` (n, 3).

    The assembly knows nothing of the prescribed ones, so that reactions and whole tangents can be read.
    """

    def __init__(self, mesh: RodMesh, material: SolidMaterial, formulation: Formulation, fixed: Mask) -> None:
        self.mesh = mesh
        self.fixed = fixed
        self.assembly = SolidAssembly(mesh, np.zeros(fixed.shape, bool))
        self.form = solid_form(formulation, material, self.assembly)

    def energy(self, u: Floats) -> float:
        """Strain energy [J]."""
        return self.form.energy(self.assembly.deformation_gradient(u))

    def force(self, u: Floats) -> Floats:
        """Nodal forces of the stress (n, 3) [N], supports included: there they are the reactions."""
        F = self.assembly.deformation_gradient(u)
        return self.assembly.internal_force(self.form.stress(F))

    def tangent(self, u: Floats) -> csr_array:
        """Tangent (3 n, 3 n) [N/m] of all components, prescribed ones too."""
        F = self.assembly.deformation_gradient(u)
        rate = self.form.linearise(F)
        return self.assembly.tangent(rate.A_pk1, None, rate.K_element)

    def equilibrium(self, start: Floats, load: Floats | None = None) -> Floats:
        """Displacement (n, 3) [m] under nodal loads (n, 3) [N]; prescribed components stay as in `start`.

        Raises
        ------
        NoEquilibrium
            When Newton's method does not converge.
        """
        u = start.copy()
        free = np.flatnonzero(~self.fixed.ravel())
        size = float(np.ptp(self.mesh.nodes))
        step, right, scale = np.inf, np.inf, 1.0
        for _ in range(MAX_ITERATIONS):
            force = self.force(u)
            gap = (-force if load is None else load - force).ravel()[free]
            right, scale = float(np.linalg.norm(gap)), float(np.linalg.norm(force))
            if right <= TOLERANCE * scale or step <= STALLED * size:
                return u
            du = np.zeros(u.size)
            du[free] = np.asarray(spsolve(self.tangent(u)[free][:, free].tocsc(), gap), float)
            if not np.all(np.isfinite(du)):
                break
            u, step = self._advance(u, du.reshape(u.shape))
        raise NoEquilibrium(
            f"residual {right / scale:.1e}, no equilibrium within {MAX_ITERATIONS} iterations"
        )

    def _advance(self, u: Floats, du: Floats) -> tuple[Floats, float]:
        """Newton step, halved until the law has a value everywhere; returns the state and the step's size."""
        where = ""
        for _ in range(MAX_HALVINGS):
            F = self.assembly.deformation_gradient(u + du)
            where = self.form.inadmissible(F)
            if not where:
                return u + du, float(np.abs(du).max())
            du = du / 2
        raise NoEquilibrium(f"{MAX_HALVINGS} halvings of the step do not cure it: {where}")


def boundary_nodes(mesh: RodMesh) -> NDArray[np.int64]:
    """Nodes on the surface of the mesh."""
    dofs = mesh.hexes.dofs.get_facet_dofs(mesh.hexes.boundary_facets()).all()
    number = np.empty_like(mesh.order)
    number[mesh.order] = np.arange(len(mesh.order))
    return number[dofs]


def distorted(mesh: RodMesh, amount: float, seed: int = 0) -> RodMesh:
    """The same body with every inner node moved at random by up to `amount` [m] in each direction.

    Raises
    ------
    ValueError
        When that turns an element inside out somewhere.
    """
    nodes = mesh.nodes.copy()
    inner = np.setdiff1d(np.arange(len(nodes)), boundary_nodes(mesh))
    nodes[inner] += np.random.default_rng(seed).uniform(-amount, amount, (len(inner), 3))
    doflocs = np.empty((3, len(nodes)))
    doflocs[:, mesh.order] = nodes.T
    hexes = MeshHex2(doflocs, mesh.hexes.t)
    samples = np.stack(np.meshgrid(*3 * [np.linspace(0, 1, 7)])).reshape(3, -1)
    volume = np.asarray(hexes.mapping().detDF(samples))
    if volume.min() * volume.max() <= 0:
        raise ValueError(f"moving the inner nodes by {amount} m turns an element inside out; take less.")
    return replace(mesh, nodes=nodes, hexes=hexes)


def manufactured_load(mesh: RodMesh, motion: WaveMotion, law: InvariantLaw, fixed: Mask) -> Floats:
    """Nodal loads (n, 3) [N]: int b N_a dV + int t N_a dA over the surface that is not held."""
    load = np.zeros(mesh.nodes.shape)

    def add(basis: Basis | FacetBasis, density: Callable[[Floats], Floats]) -> None:
        X = np.moveaxis(np.asarray(basis.global_coordinates()), 0, -1)
        weighted = density(X) * np.asarray(basis.dx)[..., None]  # (n_el, n_qp, 3)
        nodal = np.zeros(mesh.nodes.shape)
        for a, shape in enumerate(basis.basis):
            share = np.sum(np.asarray(shape[0])[..., None] * weighted, axis=1)
            np.add.at(nodal, basis.element_dofs[a], share)
        load[:] += nodal[mesh.order]

    add(Basis(mesh.hexes, ElementHex2(), intorder=FINE_ORDER), lambda X: body_force(motion, law, X))
    number = np.flatnonzero(fixed.all(axis=1))
    surface = mesh.hexes.boundary_facets()
    if len(np.setdiff1d(boundary_nodes(mesh), number)):
        held = np.all(np.isin(_facet_vertices(mesh, surface), number), axis=0)
        facets = FacetBasis(mesh.hexes, ElementHex2(), facets=surface[~held], intorder=FINE_ORDER)
        normal = np.moveaxis(np.asarray(facets.normals), 0, -1)
        add(facets, lambda X: traction(motion, law, X, normal))
    return load


def errors(mesh: RodMesh, motion: WaveMotion, u: Floats) -> tuple[float, float]:
    """Relative L2 errors of the displacement and of its gradient against the motion."""
    basis = Basis(mesh.hexes, ElementHex2(), intorder=FINE_ORDER)
    X = np.moveaxis(np.asarray(basis.global_coordinates()), 0, -1)
    nodal = u[mesh.elements]  # (n_el, 27, 3)
    value = sum(np.asarray(f[0])[..., None] * nodal[:, None, a] for a, f in enumerate(basis.basis))
    slope = sum(
        nodal[:, None, a, :, None] * np.moveaxis(np.asarray(f[0].grad), 0, -1)[..., None, :]
        for a, f in enumerate(basis.basis)
    )
    dx = np.asarray(basis.dx)

    def norm(field: Floats) -> float:
        axes = tuple(range(2, field.ndim))
        return float(np.sqrt(np.sum(dx * np.sum(field**2, axis=axes))))

    exact = np.asarray(motion.position(X)) - X
    exact_slope = np.asarray(motion.deformation_gradient(X)) - np.eye(3)
    return norm(value - exact) / norm(exact), norm(slope - exact_slope) / norm(exact_slope)


def _facet_vertices(mesh: RodMesh, facets: NDArray[np.int64]) -> NDArray[np.int64]:
    """Corner nodes of facets in the numbering of the rod mesh (4, n)."""
    number = np.empty_like(mesh.order)
    number[mesh.order] = np.arange(len(mesh.order))
    dofs = np.asarray(mesh.hexes.dofs.nodal_dofs, dtype=np.int64)[0]
    return number[dofs[np.asarray(mesh.hexes.facets)[:, facets]]]
