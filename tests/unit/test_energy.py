"""The elastic kernel at single states: exact zeros, spurious modes, sharing of element data."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from ancf.elements import ELEMENTS, SECTION_ELEMENTS
from ancf.materials import SaintVenantKirchhoff
from ancf.rod_model import make_rod_model
from ancf.scene import Force, Rod, Scene
from ancf.sections import Circle
from tests.strategies import draws, fewer
from validation import kernel_measures as kernel
from validation.random_rods import (
    RodRange,
    bent_state,
    random_model,
    random_rotation,
    random_state,
    random_turn,
)

every_element = pytest.mark.parametrize("name", ELEMENTS)
every_section = pytest.mark.parametrize("name", SECTION_ELEMENTS)


def rod(name, elements=3, **changes):
    return replace(
        Rod("rod", 1.0, elements, Circle(0.05), SaintVenantKirchhoff(1e6, 0.3), element=name), **changes
    )


def model(name, elements=3, mark=None, **changes):
    marks = () if mark is None else (Force("rod", mark, np.ones(3)),)
    return make_rod_model(
        Scene((rod(name, elements, **changes),), forces=marks), rod(name, elements, **changes), 0
    )


@every_section
@given(source=draws())
def test_the_reference_is_exactly_without_energy_and_force(name, source):
    """Strain products are formed from differences: zero, not small (theory.md 5)."""
    arrays = random_model(source, name)
    assert arrays.elastic.energy(arrays.e0) == 0.0
    assert not arrays.elastic.force(arrays.e0).any()


@every_element
def test_translation_changes_no_bit(name):
    """Positions enter relative to the element's first node: on coordinates that float64 holds exactly, a
    translation
    by 2^30 lengths leaves energy and force as they are (theory.md 5, round-off floor).
    """
    arrays = model(name, elements=4)
    e = arrays.e0 * 1.0
    e[:, :, 1] += np.round(np.random.default_rng(0).uniform(-1, 1, e.shape[:2]) * 2**8) / 2**12
    far = e.copy()
    far[:, arrays.elastic.position_columns] += 2.0**30 * np.array([1.0, -1.0, 2.0])
    assert np.all(
        far[:, arrays.elastic.position_columns] - e[:, arrays.elastic.position_columns] == far[0, 0] - e[0, 0]
    )
    assert arrays.elastic.energy(far) == arrays.elastic.energy(e)
    np.testing.assert_array_equal(arrays.elastic.force(far), arrays.elastic.force(e))


@every_element
@given(source=draws())
def test_energy_is_positive_in_any_strained_state(name, source):
    arrays = random_model(source, name)
    assert arrays.elastic.energy(kernel.per_element(arrays, random_state(source, arrays))) > 0.0


@every_section
@pytest.mark.parametrize("rule", ["default", "full"])
@settings(max_examples=fewer(2))
@given(source=draws())
def test_six_zero_modes_for_every_rule_in_use(name, rule, source):
    """issue 2, NUMBERS: exactly 6, in the reference and in bent, twisted states for B^T D B."""
    allowed = RodRange(elements=(1, 2, 3), slenderness=(8.0, 60.0), rules=(rule,))
    arrays = random_model(source, name, allowed)
    _, K = arrays.elastic.force_and_tangent(arrays.e0)
    assert kernel.zero_modes(kernel.assembled(arrays, K))[0] == 6
    q = bent_state(arrays, random_turn(source, arrays)) @ random_rotation(source).T
    assert kernel.zero_modes(kernel.assembled(arrays, kernel.strain_tangent(arrays, q)))[0] == 6


@pytest.mark.parametrize("elements", [1, 2, 5])
def test_3243_with_two_axial_points_has_spurious_modes(elements):
    """theory.md 3: why its default rule has three points."""
    arrays = model("3243", elements, axial_rule=2)
    _, K = arrays.elastic.force_and_tangent(arrays.e0)
    assert kernel.zero_modes(kernel.assembled(arrays, K))[0] > 6


@pytest.mark.parametrize("name", ELEMENTS)
def test_one_axial_point_is_not_enough(name):
    arrays = model(name, 2, axial_rule=1)
    _, K = arrays.elastic.force_and_tangent(arrays.e0)
    assert kernel.zero_modes(kernel.assembled(arrays, K))[0] > 6


@every_section
@given(source=draws())
def test_material_and_geometric_parts_are_the_tangent(name, source):
    """K = B^T H B + N^T S N: the material part alone at the reference, nowhere negative (constant H)."""
    arrays = random_model(source, name)
    q = random_state(source, arrays)
    e = kernel.per_element(arrays, q)
    K_mat = arrays.elastic.material_tangent(arrays.elastic.generalised(e))
    if isinstance(
        arrays.rod.material, SaintVenantKirchhoff
    ):  # the H of rubber may be indefinite under strain
        np.testing.assert_array_equal(K_mat, kernel.strain_tangent(arrays, q))
        values = np.linalg.eigvalsh(kernel.assembled(arrays, K_mat))
        assert values[0] > -1e-12 * values[-1]
    _, K0 = arrays.elastic.force_and_tangent(arrays.e0)
    parts = [part for part in (arrays.elastic, arrays.elastic.control) if part is not None]
    same = np.sum([part.material_tangent(part.v0) for part in parts], axis=0)
    np.testing.assert_allclose(K0, same, atol=1e-14 * np.abs(same).max())


@every_element
@given(source=draws())
def test_force_and_tangent_returns_the_force(name, source):
    arrays = random_model(source, name)
    e, e_previous = (kernel.per_element(arrays, random_state(source, arrays)) for _ in range(2))
    Q = arrays.elastic.force(e)
    for found in (arrays.elastic.force_and_tangent(e)[0], arrays.elastic.force_and_tangent(e, e_previous)[0]):
        np.testing.assert_allclose(found, Q, atol=1e-14 * np.abs(Q).max())


@every_section
def test_elements_of_different_length_have_their_own_stiffness(name):
    """A mark at .37 of three elements makes lengths .37, .315, .315; equal elements share one matrix."""
    assert len(model(name).elastic.section.H) == 1
    uneven = model(name, mark=0.37)
    np.testing.assert_allclose(uneven.mesh.h, [0.37, 0.315, 0.315])
    F = np.diag([1.1, 0.95, 0.97])
    density = uneven.elastic.energy(uneven.e0 @ F.T)
    assert density == pytest.approx(
        model(name).elastic.energy(model(name).e0 @ F.T), rel=1e-12
    )  # length 1 in all


@every_section
def test_bending_energy_of_an_element(name):
    """One element bent by r_yx alone: sections turn, axis stays; U = E I kappa^2 h/2 + (E/2) int (kappa
    y)^4/4 dA h.

    E_xx = -kappa y + kappa^2 y^2/2 at nu = 0 (r_x = e_x - kappa y e_x):
    U/h = E/2 (kappa^2 I + kappa^4 int y^4 / 4).
    """
    arrays = model(name, 1, material=SaintVenantKirchhoff(1e6, 0.0))
    kappa, R = 0.5, 0.05
    I, I4 = np.pi * R**4 / 4, np.pi * R**6 / 8  # noqa: E741 int y^4 dA = pi R^6 / 8
    e = arrays.e0.copy()
    per_node = len(arrays.element.vectors)
    column = arrays.element.vectors.index((0, 1, 0))
    x = arrays.mesh.node_x
    for node in range(len(arrays.element.node_xi)):
        e[0, node * per_node + column, 0] -= kappa * (x[node] - 0.5)
    # r_y is then no longer normal to r_x away from the middle: shear gamma_xy = (1 - kappa y) s and E_yy =
    # s^2/2,
    # s = kappa (x - h/2), with mean s^2 = kappa^2/12 and mean s^4 = kappa^4/80 over the element
    G, A = 5e5, np.pi * R**2
    s2, s4 = kappa**2 / 12, kappa**4 / 80
    if arrays.axial_points == 2:
        s4 = kappa**4 / 144  # two Gauss points integrate x^2, not x^4: (1/12)^2
    expected = 5e5 * (kappa**2 * I + kappa**4 * I4 / 4) + 0.5 * G * s2 * (A + kappa**2 * I) + 5e5 * A * s4 / 4
    if arrays.element.long_from:  # second difference of E_yy over the nodes: kappa^2/4; rho = R/2, h = 1
        c = (R / 2) / (1.0 + (arrays.element.long_from * R / 2) ** 2)
        expected += 0.5 * c / 45 * 1e6 * A * (kappa**2 / 4) ** 2
    assert arrays.elastic.energy(e) == pytest.approx(expected, rel=1e-12)
