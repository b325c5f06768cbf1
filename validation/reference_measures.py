"""What is measured on the solid reference: relative errors by name, for one law and one form.

Moduli near 1 Pa, sizes near 1 m: the answers do not depend on the units. Limits and promised orders are in
`reference_checks`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from reference import homogeneous, invariant_laws, solid_materials
from reference.bodies import Body, boundary_nodes, distorted, errors, manufactured_load
from reference.homogeneous import PrincipalStress
from reference.invariant_laws import InvariantLaw
from reference.manufactured import WaveMotion
from reference.oracles import condensed_energy, felupe_assembly, form_language
from reference.solid_forms import Formulation
from reference.solid_mesh import circular_section, rectangular_section, rod_mesh
from validation.reference_exact import stretched_block

Law = solid_materials.SaintVenantKirchhoff | solid_materials.NeoHookean | solid_materials.MooneyRivlin
Measure = Callable[[float], dict[str, float]]

# A motion with strains up to 0.3; with a zero diagonal it keeps the volume.
SHEAR_WAVES = np.array([[0.0, 1.5, 1.1], [1.3, 0.0, -1.2], [-1.0, 1.4, 0.0]])
SWELL_WAVES = np.diag([1.2, -1.1, 1.3])
PHASES = np.array([0.3, 0.5, -0.4])
AMPLITUDE = 0.12


@dataclass(frozen=True)
class Rubber:
    """One law three times: under test, in invariants, in principal stretches; and its Mooney-Rivlin limit."""

    name: str
    material: Law
    invariant: InvariantLaw
    principal: PrincipalStress
    c10: float = 0.0
    c01: float = 0.0


def rubbers(nu: float) -> list[Rubber]:
    """The three laws at E = 2.5 (1 + nu)/3 Pa, mu = 5/12 Pa; Mooney-Rivlin with c01 = c10/2."""
    mu = 5 / 12
    young, bulk = 2 * mu * (1 + nu), 2 * mu * (1 + nu) / (3 * (1 - 2 * nu))
    c10, c01 = mu / 3, mu / 6
    return [
        Rubber(
            "Saint Venant-Kirchhoff",
            solid_materials.SaintVenantKirchhoff(young, nu),
            invariant_laws.saint_venant_kirchhoff(young, nu),
            homogeneous.principal_saint_venant_kirchhoff(young, nu),
        ),
        Rubber(
            "neo-Hookean",
            solid_materials.NeoHookean(young, nu),
            invariant_laws.neo_hookean(young, nu),
            homogeneous.principal_neo_hookean(young, nu),
            mu / 2,
        ),
        Rubber(
            "Mooney-Rivlin",
            solid_materials.MooneyRivlin(c10, c01, bulk),
            invariant_laws.mooney_rivlin(c10, c01, bulk),
            homogeneous.principal_mooney_rivlin(c10, c01, bulk),
            c10,
            c01,
        ),
    ]


def manufactured(rubber: Rubber, form: Formulation, *, swells: bool, held: str) -> Measure:
    """Relative L2 errors of displacement and gradient.

    `held` "surface": a rod on an O-grid, body force inside; "face": a brick on its start face, tractions
    on the five others.
    """
    motion = WaveMotion(AMPLITUDE, SHEAR_WAVES + swells * SWELL_WAVES, PHASES)

    def measure(size: float) -> dict[str, float]:
        n = round(1 / size)
        curved = held == "surface"
        section = circular_section(0.5, n, n) if curved else rectangular_section(0.8, 0.8, n, n)
        mesh = rod_mesh(section, 0.8, n)
        fixed = np.zeros(mesh.nodes.shape, bool)
        fixed[boundary_nodes(mesh) if curved else mesh.plane(0)] = True
        load = manufactured_load(mesh, motion, rubber.invariant, fixed)
        exact = np.asarray(motion.position(mesh.nodes), float) - mesh.nodes
        u = Body(mesh, rubber.material, form, fixed).equilibrium(exact, load)
        return dict(zip(("displacement", "gradient"), errors(mesh, motion, u), strict=True))

    return measure


def patch(rubber: Rubber, form: Formulation, *, curved: bool) -> dict[str, float]:
    """Surface on an affine motion, inner nodes moved at random in the reference: the inside follows exactly.

    Errors of the inner positions by the size, of the energy, of the resultant on a face by the stress.
    """
    section = circular_section(0.5, 2, 1) if curved else rectangular_section(1.0, 0.8, 2, 2)
    mesh = distorted(rod_mesh(section, 1.0, 2), 0.01 if curved else 0.03, seed=1)
    F = np.array([[1.15, 0.2, -0.1], [0.05, 0.9, 0.15], [0.1, -0.2, 1.1]])
    fixed = np.zeros(mesh.nodes.shape, bool)
    fixed[boundary_nodes(mesh)] = True
    exact = mesh.nodes @ (F - np.eye(3)).T
    start = exact.copy()
    start[~fixed] += np.random.default_rng(2).uniform(-0.01, 0.01, int(np.sum(~fixed)))
    body = Body(mesh, rubber.material, form, fixed)
    u = body.equilibrium(start)
    volume = section.area * mesh.length
    energy = float(rubber.invariant.energy(F)) * volume
    P_pk1 = np.asarray(rubber.invariant.stress(F), float)
    resultant = (body.force(u) * (mesh.nodes[:, :1] / mesh.length)).sum(
        axis=0
    )  # of X/L: P e_x times the area
    return {
        "inner nodes": float(np.abs(u - exact).max()),
        "energy": abs(body.energy(u) / energy - 1),
        "resultant": float(np.abs(resultant / section.area - P_pk1[:, 0]).max()) / float(np.abs(P_pk1).max()),
    }


def rigid_motion(rubber: Rubber, form: Formulation) -> dict[str, float]:
    """A moved body has no force and no energy; a deformed one that is turned keeps its energy.

    Its forces turn with it; their sum and their couple vanish.
    """
    mesh = distorted(rod_mesh(circular_section(0.5, 1, 1), 0.8, 2), 0.01)
    body = Body(mesh, rubber.material, form, np.zeros(mesh.nodes.shape, bool))
    Q = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    Q *= np.linalg.det(Q)
    moved = mesh.nodes @ Q.T + [0.3, -0.2, 0.5]
    motion = WaveMotion(AMPLITUDE, SHEAR_WAVES + SWELL_WAVES, PHASES)
    x = np.asarray(motion.position(mesh.nodes), float)
    force, energy = body.force(x - mesh.nodes), body.energy(x - mesh.nodes)
    turned = x @ Q.T + [0.3, -0.2, 0.5] - mesh.nodes
    size = float(np.abs(force).max())
    return {
        "force of a rigid motion": float(np.abs(body.force(moved - mesh.nodes)).max()) / size,
        "energy of a rigid motion": abs(body.energy(moved - mesh.nodes)) / energy,
        "energy after a turn": abs(body.energy(turned) / energy - 1),
        "force after a turn": float(np.abs(body.force(turned) - force @ Q.T).max()) / size,
        "resultant force": float(np.abs(force.sum(axis=0)).max()) / size,
        "resultant couple": float(np.abs(np.cross(x, force).sum(axis=0)).max()) / size,
    }


def stretches(rubber: Rubber, form: Formulation) -> dict[str, float]:
    """Uniaxial stretch 1.3 and 0.8 and equibiaxial stretch 1.2 of a distorted cube."""
    found = {}
    for name, stretch, directions, exact in [
        ("uniaxial 1.3", 1.3, 1, homogeneous.uniaxial(rubber.principal, 1.3)),
        ("uniaxial 0.8", 0.8, 1, homogeneous.uniaxial(rubber.principal, 0.8)),
        ("equibiaxial 1.2", 1.2, 2, homogeneous.equibiaxial(rubber.principal, 1.2)),
    ]:
        for quantity, error in stretched_block(rubber.material, form, stretch, directions, exact).items():
            found[f"{name}, {quantity}"] = error
    return found


def oracle(rubber: Rubber, form: Formulation, code: str) -> dict[str, float]:
    """Nodal forces and tangent of a distorted O-grid slice in a rough state, by other code.

    `code` is "scikit-fem" or "felupe"; the mixed form is compared with derivatives of its energy.
    """
    mesh = distorted(rod_mesh(circular_section(0.5, 1, 1), 0.8, 1), 0.01)
    rng = np.random.default_rng(1)
    u = rng.uniform(-0.02, 0.02, mesh.nodes.shape)
    body = Body(mesh, rubber.material, form, np.zeros(u.shape, bool))
    tangent = body.tangent(u).toarray()
    if form == "mixed":
        directions = rng.uniform(-0.02, 0.02, (3, *u.shape))
        force, other = condensed_energy(mesh, rubber.invariant, u, directions)
        tangent = (directions.reshape(3, -1) @ tangent.T).reshape(other.shape)
    elif code == "felupe":
        force, other = felupe_assembly(mesh, rubber.material, u)
    else:
        force, other = form_language(mesh, rubber.invariant, u)

    def gap(ours: np.ndarray, theirs: np.ndarray) -> float:
        return float(np.abs(ours - theirs).max() / np.abs(theirs).max())

    return {"force": gap(body.force(u), force), "tangent": gap(tangent, other)}
