"""What the property checks measure on the kernels: strain, energy, force, tangent, loads of one rod.

Each function returns one number that is compared with a bound; 0 is perfect. They use the kernel's public
surface and,
where something has to be known independently, their own arithmetic.

Symbols
-------
q      nodal vectors of a rod (n_nodes, vectors, 3); e the same per element (n_el, nodal, 3)
c      D_11 / E_young = (1 - nu) / ((1 + nu)(1 - 2 nu)), the stiffening where it cannot contract
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ancf.effects import Effect
from ancf.rod_model import RodModel, SectionPoint
from ancf.section_energy import local_gradient, strain_matrix
from ancf.section_law import QuadraticSection
from validation.criteria import largest

Floats = NDArray[np.float64]

# Differences are taken at these fractions of the state: far above round-off, and small enough for rubber,
# whose energy is no polynomial, that what extrapolation leaves is below 1e-9.
STEPS = (1e-2, 5e-3, 2.5e-3)
STEP_SCALES = (1.0, 0.1)


def constrained_factor(model: RodModel) -> float:
    """Ratio c = D_11 / E_young [-]."""
    nu = model.rod.material.poisson_ratio
    return (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))


def per_element(model: RodModel, q: Floats) -> Floats:
    """Element vectors e (n_el, nodal, 3) of q."""
    return q[model.mesh.nodes_of].reshape(len(model.mesh.nodes_of), -1, 3)


def nodal_force(model: RodModel, q: Floats) -> Floats:
    """Elastic force (n_nodes, vectors, 3) assembled with the rod's own connectivity."""
    Q = np.zeros(model.q0.size)
    np.add.at(
        Q, model.dofs - model.first_dof, model.elastic.force(per_element(model, q)).reshape(model.dofs.shape)
    )
    return Q.reshape(model.q0.shape)


def nodal_units(model: RodModel, length: float) -> Floats:
    """Unit of each nodal vector (vectors, 1): length^(1 - order)."""
    return np.array([[length ** (1 - sum(order))] for order in model.element.vectors])


def moved(model: RodModel, rotation: Floats, translation: Floats) -> Floats:
    """The reference after a rigid motion, q (n_nodes, vectors, 3)."""
    q = model.q0 @ rotation.T
    q[:, model.element.vectors.index((0, 0, 0))] += translation
    return q


# --- strain, energy, force
# ----------------------------------------------------------------------------------------


def largest_kernel_strain(model: RodModel, q: Floats) -> float:
    """Largest Green-Lagrange strain that the kernel sees, over the outline of the sections at its axial
    points; of a cable that of the axis.
    """
    outline = model.rod.section.outline(16)
    gamma = model.elastic.gamma(model.elastic.generalised(per_element(model, q)))
    if not model.element.has_section:
        return float(np.max(np.abs(gamma[..., 0]))) / 2.0
    worst = 0.0
    for element, points in enumerate(model.elastic.v0):
        for point, v0 in enumerate(points[: model.axial_points]):
            _, weights = local_gradient(model.element, v0, outline[:, 0], outline[:, 1])
            strain = strain_matrix(weights) @ gamma[element, point]
            worst = largest(worst, float(np.max(np.abs(strain))))
    return worst


def frame_and_gradients(
    model: RodModel, e: Floats, xi: float, h: float, y: Floats, z: Floats
) -> tuple[Floats, Floats]:
    """Frame (3, 3) of the section and position gradients (n, 3, 3) of one element at xi, without
    section_energy.py.
    """
    element = model.element
    e = e - np.where(np.arange(len(e)) % len(element.vectors) == 0, 1.0, 0.0)[:, None] * e[0]
    N, N_x = element.shape(np.array([xi]), h)[0], element.shape(np.array([xi]), h, derivative=1)[0]
    phi, phi_y, phi_z = element.section_monomials(y, z)
    J = np.stack([phi @ (N_x @ e), phi_y @ (N @ e), phi_z @ (N @ e)], axis=-1)
    r_y, r_z = (N[element.directors.index(m)] @ e for m in ((1, 0), (0, 1)))
    triad = np.column_stack([np.cross(r_y, r_z), r_y, r_z])
    triad[:, 0] /= np.linalg.norm(triad[:, 0])
    values, vectors = np.linalg.eigh(triad.T @ triad)  # polar rotation = triad (triad^T triad)^-1/2
    return triad @ (vectors / np.sqrt(values)) @ vectors.T, J


def largest_gradient_strain(model: RodModel, q: Floats) -> float:
    """Largest (F^T F - I)/2 with F = J J_0^-1 formed from the shape functions alone (paper eq. 11-13)."""
    outline = model.rod.section.outline(8)
    worst = 0.0
    for e, e0, h in zip(per_element(model, q), model.e0, model.mesh.h, strict=True):
        for xi in (-1.0, -0.3, 0.6, 1.0):
            _, J = frame_and_gradients(model, e, xi, h, *outline.T)
            _, J0 = frame_and_gradients(model, e0, xi, h, *outline.T)
            F = J @ np.linalg.inv(J0)
            worst = largest(worst, float(np.max(np.abs(np.swapaxes(F, -1, -2) @ F - np.eye(3)))) / 2.0)
    return worst


def rigid_force(model: RodModel, q: Floats) -> float:
    """Largest elastic force in units of c E A, slopes' forces by c E A h: zero for a rigid motion."""
    h = float(np.min(model.mesh.h))
    axial = constrained_factor(model) * model.rod.material.young_modulus * model.rod.section.area
    return float(np.max(np.abs(nodal_force(model, q) * nodal_units(model, h)))) / (axial * h)


def force_over_floor(model: RodModel, q: Floats) -> float:
    """Largest elastic force, dimensionless by E I / L^2, over the float64 floor 10 eps (L/h) c A L^2 / I.

    theory.md 5 has n_el = L/h of equal elements; positions stored to eps L strain an element of length h by
    eps L/h, so the shortest one sets the floor of unequal elements.
    """
    rod, L = model.rod, model.rod.length
    finest = L / float(np.min(model.mesh.h))
    I = model.bending_stiffness / rod.material.young_modulus  # noqa: E741
    unit = model.bending_stiffness / L / nodal_units(model, L)
    floor = 10.0 * np.finfo(float).eps * finest * constrained_factor(model) * rod.section.area * L**2 / I
    return float(np.max(np.abs(nodal_force(model, q) / unit))) / floor


def objectivity(model: RodModel, q: Floats, rotation: Floats) -> float:
    """Relative change of energy, and of the force turned back, when a strained state turns."""
    e, turned = per_element(model, q), per_element(model, q @ rotation.T)
    U, U_turned = model.elastic.energy(e), model.elastic.energy(turned)
    Q, Q_turned = model.elastic.force(e), model.elastic.force(turned)
    return largest(
        abs(U_turned / U - 1.0), float(np.max(np.abs(Q_turned @ rotation - Q)) / np.max(np.abs(Q)))
    )


# --- derivatives
# --------------------------------------------------------------------------------------------------


def difference_order(
    f: Callable[[Floats], Floats], e: Floats, de: Floats, derivative: Floats, terms: float = 0.0
) -> tuple[float, float]:
    """Observed order of central differences of f along de, and their extrapolated error against `derivative`.

    The error of (f(e + t de) - f(e - t de)) / 2 t is t^2 f'''/6 + ..., so halving t divides it by 4 and the
    order is 2 if, and only if, `derivative` is right. It is taken from the two shortest steps, where t^4
    weighs least against a t^2 term that nearly vanishes; where f is a polynomial of degree 2 the error is
    zero at once and the order is returned as 2. The second number removes the t^2 and t^4 terms. Errors are
    relative to |derivative|, or to `terms`, the sum of its absolute terms, where those may cancel: rounding
    is relative to them. Rubber near det F = 0 needs shorter steps: the better of two scales counts, for a
    wrong derivative is wrong on both.
    """
    scale = max(float(np.max(np.abs(derivative))), terms, 1e-300)
    found = [_difference_order(f, e, de, derivative, np.multiply(STEPS, s), scale) for s in STEP_SCALES]
    return min(found, key=lambda pair: pair[1])


def _difference_order(
    f: Callable[[Floats], Floats], e: Floats, de: Floats, derivative: Floats, steps: Floats, scale: float
) -> tuple[float, float]:
    D = [(np.asarray(f(e + t * de)) - np.asarray(f(e - t * de))) / (2.0 * t) for t in steps]
    errors = [float(np.max(np.abs(d - derivative))) / scale for d in D]
    once = [(4.0 * D[i + 1] - D[i]) / 3.0 for i in (0, 1)]
    extrapolated = (16.0 * once[1] - once[0]) / 15.0
    floor = float(np.max(np.abs(extrapolated - derivative))) / scale
    if errors[0] < 1e-9:
        return 2.0, largest(errors[0], floor)
    return float(np.log(errors[1] / max(errors[2], 1e-300)) / np.log(steps[1] / steps[2])), floor


def elastic_orders(model: RodModel, q: Floats, dq: Floats) -> tuple[float, float]:
    """Worst |order - 2| and worst extrapolated error of energy -> force and force -> tangent."""
    elastic, e, de = model.elastic, per_element(model, q), per_element(model, dq)
    Q, K = elastic.force_and_tangent(e)
    power, terms = np.array(float(np.sum(Q * de))), float(np.sum(np.abs(Q * de)))
    along = np.einsum("eij,ej->ei", K, de.reshape(len(de), -1)).reshape(e.shape)
    found = [
        difference_order(lambda x: np.array(elastic.energy(x)), e, de, power, terms),
        difference_order(elastic.force, e, de, along),
    ]
    return largest(*(abs(order - 2.0) for order, _ in found)), largest(*(error for _, error in found))


def load_orders(effect: Effect, e: Floats, de: Floats) -> tuple[float, float]:
    """|order - 2| and extrapolated error of a load's tangent; |dQ| where the load claims to be constant."""
    Q, K = effect.force_and_tangent(e)
    if not np.array_equal(Q, effect.force(e)):
        return np.inf, np.inf
    if K is None:
        return 0.0, float(np.max(np.abs(effect.force(e + de) - effect.force(e))))
    along = np.einsum("eij,ej->ei", K, de.reshape(len(de), -1)).reshape(e.shape)
    order, error = difference_order(effect.force, e, de, along)
    return abs(order - 2.0), error


def mixed_tangent_difference(model: RodModel, q: Floats) -> float:
    """Mixed-integration-point tangent with the previous state equal to the present one, against the plain
    tangent.
    """
    e = per_element(model, q)
    _, plain = model.elastic.force_and_tangent(e)
    _, mixed = model.elastic.force_and_tangent(e, e)
    return float(np.max(np.abs(mixed - plain)) / np.max(np.abs(plain)))


def mixed_prediction_error(model: RodModel, q: Floats, q_previous: Floats) -> float:
    """Predicted strain products against gamma(v_o) + gamma'(v_o)(v - v_o), the linear step of the mixed
    method.
    """
    elastic = model.elastic
    v, v_o = elastic.generalised(per_element(model, q)), elastic.generalised(per_element(model, q_previous))
    slope = 0.5 * (
        elastic.gamma(v_o + (v - v_o)) - elastic.gamma(v_o - (v - v_o))
    )  # exact: gamma is quadratic
    expected = elastic.gamma(v_o) + slope
    return float(np.max(np.abs(elastic.predicted_gamma(v, v_o) - expected)) / np.max(np.abs(expected)))


# --- zero modes
# ---------------------------------------------------------------------------------------------------


def strain_tangent(model: RodModel, q: Floats) -> Floats:
    """B^T D B (n_el, 3 nodal, 3 nodal) at q with the D of the unstressed law: its zero modes are those of B.

    Only a definite D shows them, and that of strained rubber is not: the pressure of a volume changed by 10 %
    at nu = 0.496 outweighs the shear modulus.
    """
    v = model.elastic.generalised(per_element(model, q))
    _, D = model.elastic.section.response(np.zeros_like(model.elastic.gamma(v)))
    return replace(model.elastic, section=QuadraticSection(D)).material_tangent(v)


def assembled(model: RodModel, K_e: Floats) -> Floats:
    """Dense symmetric matrix (n, n) of element tangents, dimensionless by the shortest element, unit
    diagonal.
    """
    n = model.q0.size
    dofs = model.dofs - model.first_dof
    K = np.zeros((n, n))
    np.add.at(K, (dofs[:, :, None], dofs[:, None, :]), K_e)
    diagonal = np.diag(K)
    assert np.all(diagonal >= 0.0), "an indefinite matrix has no unit diagonal"
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    return K * scale * scale[:, None]


def zero_modes(K: Floats) -> tuple[int, float]:
    """Number of zero eigenvalues and the gap: the first non-zero one over the largest zero one."""
    values = np.sort(np.abs(np.linalg.eigvalsh(K)))
    zero = int(np.count_nonzero(values < 1e-13 * len(values) * values[-1]))
    return zero, float(values[zero] / max(values[max(zero - 1, 0)], 1e-300)) if zero < len(values) else 0.0


# --- loads
# --------------------------------------------------------------------------------------------------------


def moment_resultant(Q: Floats, q: Floats, M: Floats) -> float:
    """Error of sum_k q_k x Q_k = M over all nodal vectors, relative to |M|."""
    return float(np.max(np.abs(np.cross(q, Q).sum(axis=(0, 1)) - M)) / np.linalg.norm(M))


def section_spin(point: SectionPoint, e: Floats, de: Floats) -> Floats:
    """Spin w (3,) of the section for the velocity de: the polar rotation of A = sum_k d_k W_k^T moves by w.

    From the rotations at e + t de and e - t de, their difference extrapolated; written without ancf.rotation.
    """
    spins = []
    for t in (1e-3, 5e-4):
        turn = polar_rotation(point, e + t * de) @ polar_rotation(point, e - t * de).T
        spins.append(_axial(turn - turn.T) / (4.0 * t))
    return (4.0 * spins[1] - spins[0]) / 3.0


def vorticity(point: SectionPoint, e: Floats, de: Floats) -> Floats:
    """Half the curl w (3,) of the velocity de on the axis: axial vector of the skew part of J_dot J^-1."""
    J, J_dot = ((np.stack([point.N_x[0], point.N[1], point.N[2]]) @ x).T for x in (e, de))
    L = J_dot @ np.linalg.inv(J)
    return 0.5 * _axial(L - L.T)


def polar_rotation(point: SectionPoint, e: Floats) -> Floats:
    """Rotation nearest to A: R = A (A^T A)^-1/2 on the plane of the section, completed by the normals."""
    A = (point.N @ e).T @ point.W
    left, _, right = np.linalg.svd(A)
    normal = np.cross(left[:, 0], left[:, 1])
    reference = np.cross(right[0], right[1])
    return left[:, :2] @ right[:2] + np.outer(normal, reference)


def _axial(skew: Floats) -> Floats:
    """(A_32, A_13, A_21): for A = R - R^T twice the axial vector of the skew part."""
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
