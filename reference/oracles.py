"""Nodal forces and tangents of the solid reference by other code: scikit-fem's form language, and felupe.

The form language assembles from a law in invariants with tangents by complex steps; felupe brings its own
shape functions, quadrature, laws and assembly. Only the mesh is shared. For the mixed form the energy alone
is written again, with a least-squares projection: its derivatives are numerical, exact to rounding.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, BilinearForm, ElementHex2, ElementVector, LinearForm

from reference.invariant_laws import COMPLEX_STEP, Field, InvariantLaw, invariants
from reference.solid_materials import MooneyRivlin, NeoHookean, SaintVenantKirchhoff
from reference.solid_mesh import RodMesh

Floats = NDArray[np.float64]

QUADRATURE_ORDER = 5  # 27 Gauss points, as the reference: the integrals are compared as they are taken
# Weights of the eighth-order central difference, Fornberg 1988
CENTRAL = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
CENTRAL_STEP = 0.01  # of a direction: truncation falls with its eighth power, rounding grows as 1e-16/step


def form_language(mesh: RodMesh, law: InvariantLaw, u: Floats) -> tuple[Floats, Floats]:
    """Nodal forces (n, 3) [N] and tangent (3 n, 3 n) [N/m] by `LinearForm` and `BilinearForm`.

    Python calls for each of 81 x 81 shape function pairs: for a few elements only.
    """
    basis = Basis(mesh.hexes, ElementVector(ElementHex2()), intorder=QUADRATURE_ORDER)
    dofs = 3 * mesh.order[:, None] + np.arange(3)  # of node a, component i
    field = np.empty(basis.N)
    field[dofs] = u
    gradient = np.asarray(cast(Any, basis.interpolate(field)).grad)
    F = np.moveaxis(gradient, (0, 1), (-2, -1)) + np.eye(3)
    P_pk1 = np.moveaxis(np.asarray(law.stress(F), float), (-2, -1), (0, 1))
    A_pk1 = np.moveaxis(law.tangent(F), (-4, -3, -2, -1), (0, 1, 2, 3))
    force = LinearForm(lambda v, w: np.einsum("iJ...,iJ...->...", P_pk1, v.grad)).assemble(basis)
    tangent = BilinearForm(
        lambda du, v, w: np.einsum("iJ...,iJkL...,kL...->...", v.grad, A_pk1, du.grad)
    ).assemble(basis)
    flat = dofs.ravel()
    return force[dofs], np.asarray(tangent.toarray())[np.ix_(flat, flat)]


def condensed_energy(
    mesh: RodMesh, law: InvariantLaw, u: Floats, directions: Floats
) -> tuple[Floats, Floats]:
    """Nodal forces of the mixed form and its tangent along directions (m, n, 3), from nothing but its energy.

    sum over elements of int Psi_shape + U(Pi g) dV, Pi by weighted least squares on {1, X, Y, Z}. Force by
    complex steps of the energy, tangent (m, n, 3) [N] by eighth-order differences of the force.
    """
    basis = Basis(mesh.hexes, ElementHex2(), intorder=QUADRATURE_ORDER)
    slopes = np.stack([np.moveaxis(np.asarray(f[0].grad), 0, -1) for f in basis.basis], axis=2)
    points = np.moveaxis(np.asarray(basis.global_coordinates()), 0, -1)
    dx = np.asarray(basis.dx)
    force, rates = np.zeros(u.shape), np.zeros(directions.shape)
    for nodes, B, dV, X in zip(mesh.elements, slopes, dx, points, strict=True):
        span = np.column_stack([np.ones(len(dV)), X - X.mean(axis=0)])
        root = np.sqrt(dV)[:, None]
        projection = span @ np.linalg.pinv(root * span) * root.T

        def nodal_force(state: Floats, B: Floats, dV: Floats, projection: Floats) -> Floats:
            probes = state + 1j * COMPLEX_STEP * np.eye(state.size).reshape(-1, *state.shape)
            F: Field = np.einsum("sai,qaJ->sqiJ", probes, B, optimize=True) + np.eye(3)
            I1, I2, J = invariants(F)
            density = law.shape(I1, I2, J) + law.volume(law.measure(I1, J) @ projection.T)
            return (np.imag(density) @ dV / COMPLEX_STEP).reshape(state.shape)

        force[nodes] += nodal_force(u[nodes], B, dV, projection)
        for rate, direction in zip(rates, directions, strict=True):
            for reach, weight in CENTRAL.items():
                step = reach * CENTRAL_STEP * direction[nodes]
                ahead = nodal_force(u[nodes] + step, B, dV, projection)
                behind = nodal_force(u[nodes] - step, B, dV, projection)
                rate[nodes] += weight / CENTRAL_STEP * (ahead - behind)
    return force, rates


def felupe_version() -> str | None:
    """Version of felupe, None where it or its derivatives (tensortrax) are not installed."""
    if find_spec("felupe") is None or find_spec("tensortrax") is None:  # its laws need both
        return None
    import felupe

    return felupe.__version__


def felupe_assembly(
    mesh: RodMesh, material: SaintVenantKirchhoff | NeoHookean | MooneyRivlin, u: Floats
) -> tuple[Floats, Floats]:
    """Nodal forces (n, 3) [N] and tangent (3 n, 3 n) [N/m] by felupe on the same nodes.

    Its own shape functions, its 27 Gauss points and its laws; felupe must be installed.
    """
    import felupe

    element = felupe.TriQuadraticHexahedron()
    ours = 2 * np.asarray(ElementHex2.doflocs) - 1  # scikit-fem's unit cube to felupe's
    # scikit-fem takes elements of either orientation, felupe only positive volumes
    mirror = np.sign(np.asarray(mesh.hexes.mapping().detDF(np.full((3, 1), 0.5))).ravel()[0])
    gap = element.points[:, None] - ours * [mirror, 1, 1]
    place = np.argmin(np.linalg.norm(gap, axis=-1), axis=1)
    grid = felupe.Mesh(mesh.nodes, mesh.elements[:, place], "hexahedron27")
    region = felupe.Region(grid, element, felupe.GaussLegendre(order=2, dim=3))
    field = felupe.FieldContainer([felupe.Field(region, dim=3, values=cast(Any, u))])
    if isinstance(material, NeoHookean):
        law = felupe.NeoHookeCompressible(mu=material.lame_mu, lmbda=material.lame_lambda)
    elif isinstance(material, SaintVenantKirchhoff):
        law = felupe.Hyperelastic(
            felupe.saint_venant_kirchhoff, mu=material.lame_mu, lmbda=material.lame_lambda
        )
    else:
        shape = felupe.Hyperelastic(felupe.mooney_rivlin, C10=material.c10, C01=material.c01)
        law = felupe.CompositeMaterial(shape, felupe.Volumetric(bulk=material.bulk_modulus))
    body = felupe.SolidBody(law, field)
    force = np.asarray(body.assemble.vector().toarray()).reshape(-1, 3)
    return force, np.asarray(body.assemble.matrix().toarray())
