"""Rubber in Green-Lagrange strain: formulas in F, differences, small strain, uniaxial states, elements."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, strategies as st

from ancf.cauchy_green import CauchyGreen
from ancf.elements import ELEMENTS, SECTION_ELEMENTS
from ancf.hyperelastic import MooneyRivlin, NeoHookean, enhanced_potentials, full_potential
from ancf.materials import VOIGT, SaintVenantKirchhoff
from ancf.model import Model
from ancf.potentials import OfVolume
from ancf.rod_model import make_rod_model
from ancf.rotation import exp, log
from ancf.scene import Force, Frame, Gravity, Moment, Rod, Scene, SolverOptions, Support
from ancf.sections import Circle, Rectangle
from ancf.solution import Status
from ancf.solver import solve
from validation.kernel_measures import difference_order

LAWS = [
    NeoHookean(3.0, 0.3),
    NeoHookean(3.0, 0.49),
    MooneyRivlin(0.4, 0.1, 2.0),
    MooneyRivlin(0.0, 0.3, 30.0),
]
every_law = pytest.mark.parametrize("law", LAWS, ids=repr)


def voigt(E):
    return np.array([E[a, b] * (1 if a == b else 2) for a, b in VOIGT])


def gradients(size=0.25):
    """Deformation gradients (3, 3) near the identity; det F > 0 up to an entry of 1/3."""
    numbers = st.lists(st.floats(-size, size), min_size=9, max_size=9)
    return numbers.map(lambda x: np.eye(3) + np.array(x).reshape(3, 3))


def invariants_energy(law, F):
    """interface.md, literally, in I_1, I_2 and J of F."""
    C, J = F.T @ F, np.linalg.det(F)
    I_1, I_2 = np.trace(C), 0.5 * (np.trace(C) ** 2 - np.trace(C @ C))
    if isinstance(law, NeoHookean):
        mu, lame = law.lame_mu, law.lame_lambda
        return mu / 2 * (I_1 - 3 - 2 * np.log(J)) + lame / 2 * np.log(J) ** 2
    iso = law.c10 * (J ** (-2 / 3) * I_1 - 3) + law.c01 * (J ** (-4 / 3) * I_2 - 3)
    return iso + law.bulk_modulus / 2 * (J - 1) ** 2


@every_law
@given(F=gradients())
@example(F=np.eye(3))
def test_energy_is_that_of_the_interface(law, F):
    """Also for the sum of the two parts, which elements integrate by different rules."""
    strain = voigt(0.5 * (F.T @ F - np.eye(3)))
    expected = invariants_energy(law, F)
    assert full_potential(law).energy(strain) == pytest.approx(expected, rel=1e-11, abs=1e-13)
    parts = law.shape.energy(strain) + law.volume.derivatives(np.linalg.det(F) - 1.0)[0]
    assert parts == pytest.approx(expected, rel=1e-11, abs=1e-13)


def potentials_of(law):
    section, axis = enhanced_potentials(law, (0.8, 0.9))
    return [law.shape, OfVolume(law.volume), full_potential(law), section, axis]


@every_law
@pytest.mark.parametrize("which", range(5))
@given(F=gradients(0.2), direction=st.lists(st.floats(-1, 1), min_size=6, max_size=6))
def test_stress_and_tangent_are_derivatives(law, which, F, direction):
    """Differences of energy and stress converge with order 2 to S and D; D is symmetric."""
    potential = potentials_of(law)[which]
    strain = voigt(0.5 * (F.T @ F - np.eye(3)))
    d = 0.1 * np.array(direction)
    S, D = potential.response(strain)
    np.testing.assert_array_equal(potential.stress(strain), S)
    np.testing.assert_allclose(D, D.T, atol=1e-12 * np.abs(D).max())
    scale = np.abs(D).max() * max(np.abs(d).max(), 1e-3)  # of the differences
    for f, exact in ((potential.energy, S @ d), (potential.stress, D @ d)):
        order, error = difference_order(f, strain, d, np.asarray(exact))
        assert error * np.max(np.abs(exact)) < 2e-6 * scale
        if np.max(np.abs(exact)) > 1e-2 * scale and np.abs(d).max() > 0.05:
            assert abs(order - 2.0) < 0.2


@every_law
def test_no_strain_no_stress_and_hooke_nearby(law):
    """Exactly zero stress; the tangent is Hooke's matrix of E and nu (linear elasticity), D_0 for Psi_0."""
    zero = np.zeros(6)
    hooke = SaintVenantKirchhoff(law.young_modulus, law.poisson_ratio)
    section, axis = enhanced_potentials(law, (0.7, 0.9))
    D_0, _ = hooke.enhanced((0.7, 0.9))
    _, D_v = hooke.enhanced()
    for potential, D in ((full_potential(law), hooke.hooke()), (section, D_0), (axis, D_v)):
        S, found = potential.response(zero)
        assert not S.any()
        assert potential.energy(zero) == 0.0
        np.testing.assert_allclose(found, D, atol=1e-13 * np.abs(hooke.hooke()).max())


@pytest.mark.parametrize(("mu", "K"), [(1.0, 2.0), (3.0, 1e4)])
def test_constants_of_mooney_rivlin(mu, K):
    """mu = 2 (c10 + c01), E = 9 K mu/(3 K + mu), nu = (3 K - 2 mu)/(2 (3 K + mu)); the rest by elasticity."""
    law = MooneyRivlin(0.2 * mu, 0.3 * mu, K)
    assert law.lame_mu == pytest.approx(mu, rel=1e-15)
    E, nu = law.young_modulus, law.poisson_ratio
    assert pytest.approx(E, rel=1e-12) == 2 * mu * (1 + nu)
    assert law.bulk_modulus == pytest.approx(E / (3 * (1 - 2 * nu)), rel=1e-8)
    assert law.lame_lambda == pytest.approx(2 * mu * nu / (1 - 2 * nu), rel=1e-8)


@every_law
def test_small_strain_keeps_its_digits(law):
    """S = D_Hooke E (1 + O(E)) at E = 1e-12, where F^T F - I would have lost all but 4 digits."""
    strain = 1e-12 * np.array([1.0, -0.3, 0.5, 0.2, -0.7, 0.4])
    hooke = SaintVenantKirchhoff(law.young_modulus, law.poisson_ratio).hooke()
    expected = hooke @ strain
    np.testing.assert_allclose(
        full_potential(law).stress(strain), expected, rtol=0, atol=1e-10 * np.abs(expected).max()
    )


def test_volume_ratio_of_a_strain():
    """C = diag(4, 1, 1/9) and a rotation of it: J = 2/3, and C^-1 (closed)."""
    R = exp(np.array([0.3, -0.8, 0.5]))
    C = R @ np.diag([4.0, 1.0, 1.0 / 9.0]) @ R.T
    kinematics = CauchyGreen(voigt(0.5 * (C - np.eye(3))))
    assert kinematics.excess == pytest.approx(2 / 3 - 1, rel=1e-13)
    assert kinematics.log_J == pytest.approx(np.log(2 / 3), rel=1e-13)
    expected = np.linalg.inv(C)
    np.testing.assert_allclose(kinematics.C_inv, [expected[a, b] for a, b in VOIGT], rtol=1e-12)


# --- on elements
# ------------------------------------------------------------------------------------------------

FORMS = [(name, form) for name, element in SECTION_ELEMENTS.items() for form in element.formulations]
every_form = pytest.mark.parametrize(("name", "formulation"), FORMS)
every_rubber = pytest.mark.parametrize("law", [NeoHookean(1e6, 0.45), MooneyRivlin(1e5, 5e4, 2e6)], ids=repr)


def random_rod(name, formulation, law, seed, curvature=(0.0, 0.0, 0.0)):
    """A rod of two elements and a strained state of some 10 %."""
    rng = np.random.default_rng(seed)
    rod = Rod(
        "rod",
        0.5,
        2,
        Rectangle(0.12, 0.08),
        law,
        element=name,
        formulation=formulation,
        curvature=np.array(curvature),
    )
    model = make_rod_model(Scene((rod,)), rod, 0)
    unit = np.array([0.1 ** (1 - sum(order)) for order in model.element.vectors])[:, None]
    q = model.q0 + 0.03 * unit * rng.normal(size=model.q0.shape)
    return model, q[model.mesh.nodes_of].reshape(len(model.mesh.nodes_of), -1, 3), rng


@every_form
@every_rubber
@pytest.mark.parametrize("curvature", [(0, 0, 0), (0.3, -0.5, 0.8)])
def test_energy_force_tangent_on_every_element(name, formulation, law, curvature):
    """Q = dU/de, K = dQ/de with differences of order 2, K symmetric; the reference is exactly unstressed."""
    model, e, _ = random_rod(name, formulation, law, 5, curvature)
    elastic = model.elastic
    assert elastic.energy(model.e0) == 0.0
    assert not elastic.force(model.e0).any()
    de = 0.5 * (e - model.e0)[::-1]
    Q, K = elastic.force_and_tangent(e)
    np.testing.assert_allclose(Q, elastic.force(e), atol=1e-13 * np.abs(Q).max())
    scale = np.abs(K).max(axis=(1, 2), keepdims=True)
    assert np.max(np.abs(K - np.swapaxes(K, -1, -2)) / scale) < 1e-13
    along = np.einsum("eij,ej->ei", K, de.reshape(len(de), -1)).reshape(e.shape)
    for f, exact in (
        (lambda x: np.array(elastic.energy(x)), np.array(np.sum(Q * de))),
        (elastic.force, along),
    ):
        order, error = difference_order(f, e, de, exact)
        assert abs(order - 2.0) < 0.05
        assert error < 1e-6


@every_form
@every_rubber
def test_objective(name, formulation, law):
    model, e, _ = random_rod(name, formulation, law, 8, (0.0, 0.4, 0.0))
    R = exp(np.array([1.0, -2.0, 0.5]))
    turned = e @ R.T
    assert model.elastic.energy(turned) == pytest.approx(model.elastic.energy(e), rel=1e-11)
    Q = model.elastic.force(e)
    np.testing.assert_allclose(model.elastic.force(turned) @ R, Q, atol=1e-11 * np.abs(Q).max())


@every_form
@every_rubber
def test_the_mixed_integration_point_stress_is_the_linear_step(name, formulation, law):
    """The predicted stress is T + H dgamma; equal states change nothing."""
    model, e, _ = random_rod(name, formulation, law, 3)
    elastic = model.elastic
    gamma = elastic.gamma(elastic.generalised(e))
    d = 0.2 * gamma[::-1]
    T, H = elastic.section.response(gamma)
    predicted = elastic.section.predicted(gamma, gamma + d)
    np.testing.assert_allclose(predicted, T + (H @ d[..., None])[..., 0], atol=1e-12 * np.abs(T).max())
    _, plain = elastic.force_and_tangent(e)
    _, mixed = elastic.force_and_tangent(e, e)
    np.testing.assert_allclose(mixed, plain, atol=1e-10 * np.abs(plain).max())


def uniaxial(law, stretch):
    """Nominal stress [Pa] of a bar free to contract: lateral stretch by bisection on its energy's slope."""

    def energy(lateral, axial=stretch):
        return invariants_energy(law, np.diag([axial, lateral, lateral]))

    low, high = 0.5, 1.5
    for _ in range(200):
        middle = 0.5 * (low + high)
        rising = energy(middle * (1 + 1e-6)) > energy(middle * (1 - 1e-6))
        low, high = (low, middle) if rising else (middle, high)
    t = 1e-5
    return (energy(middle, stretch + t) - energy(middle, stretch - t)) / (2 * t)


@every_form
@every_rubber
@pytest.mark.parametrize("stretch", [0.8, 1.5])
def test_bar_free_to_contract_follows_the_full_law(name, formulation, law, stretch):
    """Uniform states are those of the law, whatever the formulation (benchmarks.md AX)."""
    section = Rectangle(0.1, 0.05)
    rod = Rod(
        "rod",
        0.3,
        2,
        section,
        law,
        element=name,
        formulation=formulation,
        supports=(Support(0.0, "free_section_clamp"),),
    )
    load = uniaxial(law, stretch) * section.area
    solution = solve(Scene((rod,), forces=(Force("rod", 1.0, np.array([load, 0.0, 0.0])),)))
    assert solution.status is Status.CONVERGED
    np.testing.assert_allclose(solution.tip().position, [0.3 * stretch, 0.0, 0.0], atol=1e-6)


@pytest.mark.parametrize("name", SECTION_ELEMENTS)
def test_incompressible_limit(name):
    """benchmarks.md AX: mu = 9e5, A = .01, 9500 N gives 1.5 (mu (s - s^-2) A = 9500); 1e-3 at K/mu = 1e3."""
    mu, ratio = 9e5, 1e3
    nu = (3 * ratio - 2) / (2 * (3 * ratio + 1))
    for law in (NeoHookean(2 * mu * (1 + nu), nu), MooneyRivlin(mu / 2, 0.0, ratio * mu)):
        rod = Rod(
            "rod",
            1.0,
            2,
            Rectangle(0.1, 0.1),
            law,
            element=name,
            supports=(Support(0.0, "free_section_clamp"),),
        )
        solution = solve(Scene((rod,), forces=(Force("rod", 1.0, np.array([9500.0, 0.0, 0.0])),)))
        assert solution.tip().position[0] == pytest.approx(1.5, abs=1e-3)


@pytest.mark.parametrize("name", SECTION_ELEMENTS)
@pytest.mark.parametrize("nu", [0.3, 0.45, 0.49, 0.499, 0.4999])
@pytest.mark.parametrize("angle", [0.0, np.pi / 4])
def test_bending_stiffness_does_not_lock(name, nu, angle):
    """issue 3: EI_eff/EI = 1 within 1e-3 up to nu = .4999, also with the base turned by 45 degrees."""
    mu = 1e6 / (2 * (1 + nu))
    rubber = MooneyRivlin(0.35 * mu, 0.15 * mu, 1e6 / (3 * (1 - 2 * nu)))
    section, L, theta = Circle(0.05), 10.0, 0.01
    A_o = exp(np.array([angle, 0.0, 0.0]))
    M = 1e6 * section.weaker_second_moment * theta / L * A_o[:, 2]
    for law in (NeoHookean(1e6, nu), rubber):
        rod = Rod(
            "rod",
            L,
            8,
            section,
            law,
            element=name,
            base=Frame(np.zeros(3), A_o),
            supports=(Support(0.0, "free_section_clamp"),),
        )
        solution = solve(Scene((rod,), moments=(Moment("rod", 1.0, M),)))
        turned = log(solution.tip().rotation) @ A_o[:, 2]
        assert theta / turned == pytest.approx(1.0, abs=1e-4)


def test_a_step_that_would_invert_a_section_is_halved():
    """A rubber bar pushed to half its length: every Newton iterate keeps det F > 0, and it converges."""
    law = NeoHookean(1e6, 0.45)
    rod = Rod("rod", 0.3, 2, Rectangle(0.3, 0.3), law, supports=(Support(0.0, "free_section_clamp"),))
    load = uniaxial(law, 0.5) * 0.09
    scene = Scene((rod,), forces=(Force("rod", 1.0, np.array([load, 0.0, 0.0])),))
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    assert solution.tip().position[0] == pytest.approx(0.15, rel=1e-5)


@pytest.mark.parametrize("name", ["3333", "3363"])
def test_an_inverted_start_is_recognised(name):
    """det F < 0 is invisible to strain: mirrored sections have none, and the kernel must look at F itself."""
    rod = Rod("rod", 0.3, 2, Circle(0.02), NeoHookean(1e6, 0.45), element=name)
    model = Model(Scene((rod,), solver=SolverOptions(max_steps=5)))
    q = model.q0.copy().reshape(-1, len(ELEMENTS[name].vectors), 3)
    assert not model.inside_out(q.ravel())
    q[:, ELEMENTS[name].vectors.index((0, 1, 0))] *= -1.0
    assert model.inside_out(q.ravel())
    smallest = model.rods[0].elastic.section.smallest_volume(model.rods[0].generalised(q.ravel()))
    assert smallest is not None
    np.testing.assert_allclose(smallest, -1.0, rtol=1e-12)


@pytest.mark.parametrize("name", SECTION_ELEMENTS)
@pytest.mark.parametrize("section", [Circle(0.01), Rectangle(0.02, 0.01)], ids=["circle", "rectangle"])
def test_a_load_in_a_plane_of_symmetry_leaves_the_rod_in_it(name, section):
    """Hanging steeply, the arm would show any asymmetry of the section's rule a hundredfold."""
    law = NeoHookean(0.5e6, 0.45, density=1070.0)
    for down in (np.array([0.0, 0.0, -9.81]), np.array([0.0, -9.81, 0.0])):
        solution = solve(Scene((Rod("rod", 0.4, 8, section, law, element=name),), gravity=Gravity(down)))
        assert solution.status is Status.CONVERGED
        across = np.flatnonzero(down[1:] == 0.0)[0] + 1
        assert abs(solution.tip().position[across]) < 1e-12
