"""Stress at points of a section: closed forms, constant strain, and the forces it has to carry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ancf.elements import SECTION_ELEMENTS
from ancf.errors import InputError
from ancf.hyperelastic import MooneyRivlin, NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.rod_model import make_rod_model
from ancf.scene import Force, Frame, Moment, Rod, Scene, Support
from ancf.section_stress import along_rod, cauchy_stress, deformation_gradient
from ancf.sections import Circle, Rectangle
from validation.energy_measures import patch_stress
from validation.random_rods import RngDraws, random_rotation
from validation.solution_measures import solved

RADIUS = 0.01
I = np.pi * RADIUS**4 / 4  # noqa: E741
LAWS = {
    "svk": SaintVenantKirchhoff(1e6, 0.3),
    "nh": NeoHookean(1e6, 0.45),
    "mr": MooneyRivlin(1.0e5, 0.6e5, 5e6),
}
BASE = Frame(np.array([1.0, 2.0, 3.0]), random_rotation(RngDraws(np.random.default_rng(3))))
KINDS = [(name, formulation) for name, e in SECTION_ELEMENTS.items() for formulation in e.formulations]

every_kind = pytest.mark.parametrize(("element", "formulation"), KINDS)
every_law = pytest.mark.parametrize("law", LAWS)


def rod(element="3333", formulation="", law="svk", **changes):
    made = Rod("rod", 0.4, 12, Circle(RADIUS), LAWS[law], element, formulation, base=BASE)
    return replace(made, **changes)


@every_kind
@every_law
def test_constant_strain_has_the_stress_of_the_law(element, formulation, law):
    """P F^T / det F of the law in F (reference/solid_materials.py), large strain, unequal elements."""
    spec = rod(element, formulation, law, elements=2, section=Rectangle(0.02, 0.01))
    scene = Scene((spec,), forces=(Force("rod", 0.3, np.ones(3)),))
    F = np.array([[1.3, 0.1, -0.05], [0.2, 0.9, 0.1], [0.0, -0.15, 0.85]])
    assert patch_stress(make_rod_model(scene, spec, 0), F) < 1e-12


@pytest.mark.parametrize("element", SECTION_ELEMENTS)
@every_law
def test_bending_and_torsion_are_navier_and_coulomb(element, law):
    """sigma_xx = -M_z y/I + M_y z/I, tau = T r/J, in the axes of the turned section; strains of 1e-5.

    Sections free at the clamp: 3363 would otherwise show a lateral stress that alternates between the axial
    points and fades along the rod.
    """
    M = np.array([2.0, -3.0, 5.0]) * 1e-5 * LAWS[law].young_modulus * I / RADIUS / 5
    spec = rod(element, law=law, supports=(Support(0.0, "free_section_clamp"),))
    solution = solved(Scene((spec,), moments=(Moment("rod", 1.0, BASE.rotation @ M),)))
    y, z = np.array([0.01, -0.003, 0.0, 0.004]), np.array([0.0, 0.005, -0.01, 0.004])
    stress = solution.section_stress("rod", 0.52, y, z)
    assert stress.shape == (4, 3, 3)
    expected = np.zeros((4, 3, 3))
    expected[:, 0, 0] = (M[1] * z - M[2] * y) / I
    expected[:, 0, 1] = expected[:, 1, 0] = -M[0] * z / (2 * I)
    expected[:, 0, 2] = expected[:, 2, 0] = M[0] * y / (2 * I)
    # 3243 locks by 1 % at this length of its elements; second-order stress is 1e-5 of this one.
    atol = (2e-2 if element == "3243" else 2e-4) * np.abs(expected).max()
    np.testing.assert_allclose(stress, expected, atol=atol)


@every_law
@pytest.mark.parametrize("element", ["3333", "3363"])
def test_stress_is_linear_between_and_beyond_the_axial_points(element, law):
    """Tip force F: M = F (L - x), so sigma_xx = F (L - x) y/I is linear along the rod; exact at both ends."""
    E = LAWS[law].young_modulus
    F = 1e-4 * E * I / 0.16
    solution = solved(Scene((rod(element, law=law),), forces=(Force("rod", 1.0, F * BASE.rotation[:, 1]),)))
    for at in (0.2, 0.5, 0.77, 0.9):
        stress = solution.section_stress("rod", at, 0.01, 0.0)[0, 0, 0]
        assert stress == pytest.approx(-F * 0.4 * (1 - at) * 0.01 / I, abs=3e-3 * F * 0.4 * 0.01 / I)


def test_along_rod_keeps_a_linear_field():
    model = make_rod_model(Scene((rod(),)), rod(), 0)
    x = model.axial_abscissae.ravel() / 0.4
    values = np.column_stack([3.0 - 2.0 * x, 5.0 * x])
    for at in (0.0, 0.01, 0.5, x[7], 1.0):
        np.testing.assert_allclose(along_rod(model, values, at), [3.0 - 2.0 * at, 5.0 * at], atol=1e-14)
    single = replace(rod(), elements=1, axial_rule=1)
    one = make_rod_model(Scene((single,)), single, 0)
    np.testing.assert_array_equal(along_rod(one, values[:1], 0.9), values[0])


@every_kind
@every_law
def test_stress_carries_the_section_force_and_moment(element, formulation, law):
    """int P_1 dA and int (r - r_axis) x P_1 dA against the resultants of the kernel, strains of some percent.

    `continuum` of a linear section: the same integral, so exact for its rule. The two others show Poisson's
    part and the pressure by another field than the energy does: equal to second order in the strain, .02^2.
    """
    spec = rod(element, formulation, law, elements=8, section=Rectangle(0.02, 0.015))
    E = LAWS[law].young_modulus
    load = 0.5 * E * spec.section.weaker_second_moment / 0.16
    solution = solved(
        Scene(
            (spec,),
            moments=(Moment("rod", 1.0, 0.4 * load * np.array([0.5, -0.6, 0.7])),),
            forces=(Force("rod", 1.0, load * np.array([0.3, 0.5, -0.4])),),
        )
    )
    model = solution.model.rods[0]
    y, z, area = spec.section.quadrature(12)
    F = deformation_gradient(model, solution.q, y, z)
    sigma = cauchy_stress(model, solution.q, y, z)
    P_x = np.linalg.det(F)[..., None] * np.einsum("mnij,mnj->mni", sigma, np.linalg.inv(F)[..., 0, :])
    at = solution.section_forces().at
    arm = solution.displaced("rod", at[:, None], y, z) - solution.displaced("rod", at, 0.0, 0.0)[:, None]
    forces = solution.section_forces()
    exact = formulation == "continuum" and element != "3363"
    for found, expected in (
        (np.einsum("n,mni->mi", area, P_x), forces.force),
        (np.einsum("n,mni->mi", area, np.cross(arm, P_x)), forces.moment),
    ):
        atol = (1e-8 if exact else 2e-2) * np.abs(expected).max()
        np.testing.assert_allclose(found, expected, atol=atol)


def test_stress_turns_with_the_base():
    """The axes of the section turn with the rod, so a turned scene shows the same stress."""
    stresses = []
    for rotation in (np.eye(3), BASE.rotation):
        spec = rod("3363", law="nh", base=Frame(np.zeros(3), rotation))
        F = rotation @ np.array([0.1, 0.2, -0.15]) * 1e6 * I / 0.16
        solution = solved(Scene((spec,), forces=(Force("rod", 1.0, F),)))
        stresses.append(solution.section_stress(None, 0.3, [0.005, -0.01], [0.005, 0.0]))
    np.testing.assert_allclose(*stresses, atol=1e-8 * np.abs(stresses[0]).max())


def test_pulled_rod_shows_true_stress():
    """Uniaxial: sigma_xx = P/(A t^2) with the lateral stretch t of the solution, all else zero."""
    P = 0.2 * 1e6 * np.pi * RADIUS**2
    held = rod("3333", law="nh", elements=2, supports=(Support(0.0, "free_section_clamp"),))
    solution = solved(Scene((held,), forces=(Force("rod", 1.0, P * BASE.rotation[:, 0]),)))
    t = np.linalg.norm(solution.tip().r_y)
    expected = np.diag([P / (np.pi * RADIUS**2 * t**2), 0.0, 0.0])
    np.testing.assert_allclose(solution.section_stress("rod", 0.4, 0.003, 0.001)[0], expected, atol=1e-3)


@pytest.mark.parametrize(
    ("at", "y", "z", "message"),
    [
        (1.5, 0.0, 0.0, "no such place on the rod"),
        (float("nan"), 0.0, 0.0, "no such place on the rod"),
        (0.5, 1.0, 0.0, "no stress outside the section"),
        (0.5, float("nan"), 0.0, "no stress outside the section"),
    ],
)
def test_places_off_the_rod_are_refused(at, y, z, message):
    solution = solved(Scene((Rod("rod", 0.4, 2, Circle(0.01), SaintVenantKirchhoff(1e6, 0.3)),)))
    with pytest.raises(InputError, match=message):
        solution.section_stress(None, at, y, z)


def test_values_along_the_rod_are_those_of_the_axial_points_and_linear_between():
    """On a quadratic, another interval would show."""
    model = make_rod_model(*_scene_of(Rod("rod", 0.4, 3, Circle(0.01), SaintVenantKirchhoff(1e6, 0.3))))
    x = model.axial_abscissae.ravel() / 0.4
    for i, here in enumerate(x):
        assert along_rod(model, x**2, here) == pytest.approx(here**2, rel=1e-12)
        if i:
            middle = 0.5 * (x[i - 1] + here)
            assert along_rod(model, x**2, middle) == pytest.approx(0.5 * (x[i - 1] ** 2 + here**2), rel=1e-12)
    slope = (x[-1] ** 2 - x[-2] ** 2) / (x[-1] - x[-2])
    assert along_rod(model, x**2, 1.0) == pytest.approx(x[-1] ** 2 + slope * (1.0 - x[-1]), rel=1e-12)


def _scene_of(rod):
    return Scene((rod,)), rod, 0
