"""Problems without a reference: what every correct program meets exactly (rigid motion, patch, "
"moments, far base)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.effects import moment
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.rod_model import RodModel
from ancf.rotation import exp, section_rotation
from ancf.section_energy import local_gradient, strain_matrix
from validation.cases import Case
from validation.criteria import largest
from validation.outcome import Outcome, Row
from validation.scenes import Stiffness, changed, in_si, solve, stiffness_of

Floats = NDArray[np.float64]

TURNS = (np.array([0.3, -1.1, 0.7]), np.array([2.0, 1.5, -1.2]), np.array([0.0, 0.0, 3.1]))  # rad, arbitrary
SEED = 20230811  # of the random states; any other serves
EPS = float(np.finfo(float).eps)


def _model(case: Case, variant: dict) -> Model:
    return Model(ancf.scene_from_dict(changed(case.scene, variant)))


def _moved(rod: RodModel, gradient: Floats, shift: Floats) -> Floats:
    """Nodal coordinates (n,) after the homogeneous map X -> gradient X + shift."""
    q = np.einsum("ij,nvj->nvi", gradient, rod.q0)
    q[:, rod.element.vectors.index((0, 0, 0))] += shift
    return q.ravel()


def _strain(rod: RodModel, q: Floats) -> Floats:
    """Green-Lagrange strain (..., 6) in section axes at the axial points and the outline of the section."""
    outline = rod.rod.section.outline(12)
    v = rod.elastic.generalised(q[rod.dofs].reshape(len(rod.dofs), -1, 3))
    found = []
    for element in range(v.shape[0]):
        for point in range(rod.axial_points):
            _, weights = local_gradient(
                rod.element, rod.elastic.v0[element, point], outline[:, 0], outline[:, 1]
            )
            found.append(strain_matrix(weights) @ rod.elastic.gamma(v)[element, point])
    return np.array(found)


def rigid_motion(case: Case) -> Outcome:
    """Turn and shift whole rods of several kinds: strain and force must vanish."""
    strain = force = strain_far = 0.0
    for variant in case.parameters["variants"]:
        model = _model(case, variant)
        rod = model.rods[0]
        numbers = Stiffness.of(rod.rod)
        for turn in TURNS:
            q = _moved(rod, exp(turn), np.array([0.3, -0.2, 0.5]) * numbers.length)
            strain = largest(strain, float(np.max(np.abs(_strain(rod, q)))))
            Q = model.residual(q).Q_int * model.unit / (numbers.EA * numbers.length)
            force = largest(force, float(np.max(np.abs(Q))))
        far = np.array([1e6, 0.0, 0.0])
        bound = 10.0 * EPS * 1e6 / float(np.min(rod.mesh.h))
        far_here = float(np.max(np.abs(_strain(rod, _moved(rod, np.eye(3), far)))))
        strain_far = largest(strain_far, far_here / bound)
    observed = {"strain": strain, "force/(E A)": force, "strain, coordinates 1e6 m away": strain_far}
    rows = [Row("largest strain", strain, 0.0, "-"), Row("largest force/(E A)", force, 0.0, "-")]
    return Outcome(
        observed, rows, notes=[f"{len(case.parameters['variants'])} rods, {len(TURNS)} turns each"]
    )


def patch(case: Case) -> Outcome:
    """Constant strain on elements of unequal length: strain, energy, nodal forces and their power are exact.

    r = F X for stretch, shear and section stretch; E = (F^T F - I)/2, U = A L E:D:E/2, power of the nodal
    forces in any other homogeneous motion H is A L P:H with P = F S.
    """
    worst = {"strain": 0.0, "energy": 0.0, "power of the nodal forces": 0.0, "force on inner nodes": 0.0}
    gradients = {name: np.eye(3) + np.array(g, float) for name, g in case.parameters["gradients"].items()}
    for variant in case.parameters["variants"]:
        model = _model(case, variant)
        rod = model.rods[0]
        volume = rod.rod.length * rod.rod.section.area
        material = rod.rod.material
        if not isinstance(material, SaintVenantKirchhoff):
            raise TypeError("the exact stress of this patch is D E: Saint Venant-Kirchhoff only")
        D = material.hooke()
        for F in gradients.values():
            q = _moved(rod, F, np.zeros(3))
            A_o = rod.rod.base.rotation
            E = 0.5 * A_o.T @ (F.T @ F - np.eye(3)) @ A_o  # in section axes
            voigt = np.array([E[0, 0], E[1, 1], E[2, 2], 2 * E[1, 2], 2 * E[0, 2], 2 * E[0, 1]])
            s = D @ voigt
            S = np.array([[s[0], s[5], s[4]], [s[5], s[1], s[3]], [s[4], s[3], s[2]]])
            P = F @ A_o @ S @ A_o.T
            energy = 0.5 * volume * float(voigt @ s)
            Q = model.residual(q).Q_int
            nodal = Q.reshape(rod.q0.shape)
            power = np.einsum("nvi,nvj->ij", nodal, rod.q0)  # power of Q in r = H X is H : power
            scale = float(np.max(np.abs(P)))
            inner = nodal[1:-1, rod.element.vectors.index((0, 0, 0))]
            found = {
                "strain": np.max(np.abs(_strain(rod, q) - voigt)),
                "energy": abs(rod.elastic.energy(q[rod.dofs].reshape(len(rod.dofs), -1, 3)) / energy - 1.0),
                "power of the nodal forces": np.max(np.abs(power - volume * P)) / (volume * scale),
                "force on inner nodes": np.max(np.abs(inner)) / (rod.rod.section.area * scale),
            }
            worst = {name: largest(worst[name], float(found[name])) for name in worst}
    rows = [Row(f"worst deviation: {name}", value, 0.0, "-") for name, value in worst.items()]
    count = len(gradients) * len(case.parameters["variants"])
    return Outcome(worst, rows, notes=[f"{count} combinations of rod and deformation"])


def moment_identities(case: Case) -> Outcome:
    """Both moments on random deformed sections: resultant, power in a spin, tangent against differences."""
    rng = np.random.default_rng(SEED)
    worst = {"sum of r_a x Q_a = M": 0.0, "power in a spin = M.w": 0.0, "tangent against differences": 0.0}
    for variant in case.parameters["variants"]:
        for definition in ("section", "vorticity"):
            for direction in ("fixed", "follower"):
                load = {"value": [0.3, -0.7, 0.5], "definition": definition, "direction": direction}
                model = Model(ancf.scene_from_dict(changed(case.scene, variant, moment=[load])))
                for e in _random_sections(model, rng):
                    for name, value in _identities(model, e, rng).items():
                        worst[name] = largest(worst[name], value)
    return Outcome(worst, [Row(f"worst deviation: {name}", value, 0.0, "-") for name, value in worst.items()])


def _loaded(model: Model) -> Any:
    """The one moment of the scene, as the solver's effect."""
    return moment.build(model.scene, model.rods)[0]


def _random_sections(model: Model, rng: np.random.Generator, count: int = 5) -> Iterator[Floats]:
    """Nodal vectors (1, nodal, 3) of the loaded block, turned at random and deformed by some 10 %."""
    e0 = model.q0[_loaded(model).dofs].reshape(1, -1, 3)
    for _ in range(count):
        yield e0 @ exp(rng.normal(size=3)).T + 0.1 * _block_unit(model) * rng.normal(size=e0.shape)


def _block_unit(model: Model) -> Floats:
    """Size (1, nodal, 3) of the loaded block's unknowns: element length for positions, 1 for gradients."""
    unit = model.unit[_loaded(model).dofs].reshape(1, -1, 3)
    return np.where(unit == 1.0, 1.0, unit / model.scene.rods[0].elements)


def _identities(model: Model, e: Floats, rng: np.random.Generator) -> dict[str, float]:
    """Deviations of the loaded block at e from the moment identities, relative to |M|."""
    effect = _loaded(model)
    Q, tangent = effect.force_and_tangent(e)
    resultant = np.cross(e, Q).sum(axis=(0, 1))
    section = section_rotation(effect.point.N @ e[0], effect.point.W).R
    M = section @ effect.value if effect.follower else effect.value
    size = float(np.linalg.norm(M))
    spin = rng.normal(size=3)
    power = float(np.sum(Q * np.cross(spin, e)))
    direction = _block_unit(model) * rng.normal(size=e.shape)
    predicted = tangent[0] @ direction.ravel()
    step = 2e-4
    # Fourth-order difference: truncation falls with step^4 to some 1e-10, rounding leaves 1e-16/step.
    ahead = [effect.force(e + k * step * direction).ravel() for k in (-2, -1, 1, 2)]
    difference = (ahead[0] - 8 * ahead[1] + 8 * ahead[2] - ahead[3]) / (12 * step)
    return {
        "sum of r_a x Q_a = M": float(np.max(np.abs(resultant - M))) / size,
        "power in a spin = M.w": abs(power - float(M @ spin)) / size,
        "tangent against differences": float(
            np.max(np.abs(difference - predicted)) / np.max(np.abs(predicted))
        ),
    }


def far_base(case: Case) -> Outcome:
    """The same arm at the origin and with its base 1e6 m away: equal tips relative to the base."""
    near_scene = in_si(case.scene)
    base = {**case.rod.get("base", {}), "position": case.parameters["position"]}
    far_scene = changed(near_scene, {"base": base})
    near, far = solve(near_scene), solve(far_scene)
    length = stiffness_of(near_scene).length
    found = far.tip().position - far.scene.rods[0].base.position
    exact = near.tip().position - near.scene.rods[0].base.position
    rows = [
        Row(f"tip {a} - base", float(f), float(e), "m") for a, f, e in zip("xyz", found, exact, strict=True)
    ]
    observed = {
        "tip relative to the base": float(np.max(np.abs(found - exact))) / length,
        "tip rotation": float(np.max(np.abs(far.tip().rotation - near.tip().rotation))),
    }
    return Outcome(observed, rows, near, near_scene)


def zero_modes(case: Case) -> Outcome:
    """Number of zero modes of the unsupported tangent, and of B^T D B in bent and twisted states: six.

    A mode counts as zero when its eigenvalue is below 1e-10 of the largest, with unknowns made dimensionless.
    """
    observed, rows = {}, []
    for variant in case.parameters["variants"]:
        scene = in_si(changed(case.scene, variant))
        solution = solve(scene)
        rod = solution.model.rods[0]
        for state, q in (("unstressed", solution.model.q0), ("bent and twisted", solution.q)):
            values = np.sort(np.abs(np.linalg.eigvalsh(_material_tangent(rod, q, solution.model.unit))))
            count = int(np.sum(values < 1e-10 * values[-1]))
            name = f"{rod.rod.element}, {rod.axial_points} axial points, {state}"
            observed[f"zero modes - 6: {name}"] = abs(count - 6.0)
            rows.append(Row(name, float(count), 6.0, "modes"))
    return Outcome(observed, rows)


def _material_tangent(rod: RodModel, q: Floats, unit: Floats) -> Floats:
    """Dimensionless B^T D B (n, n) of an unsupported rod."""
    v = rod.elastic.generalised(q[rod.dofs].reshape(len(rod.dofs), -1, 3))
    K = np.zeros((len(q), len(q)))
    for dofs, K_e in zip(rod.dofs, rod.elastic.material_tangent(v), strict=True):
        K[np.ix_(dofs, dofs)] += K_e
    return K * np.outer(unit, unit)
