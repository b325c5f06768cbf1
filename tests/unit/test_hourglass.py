"""Hourglass control: long elements with sections that may warp stand on a clamp that leaves them free."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ancf.elements import ELEMENTS, R_Y, R_Z
from ancf.hourglass import NODES, control_weight, swelling
from ancf.hyperelastic import NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.rod_model import make_rod_model
from ancf.scene import Force, Moment, Rod, Scene, Support
from ancf.sections import Circle
from ancf.solver import solve
from reference.elastica import elastica_tip_force

CONTROLLED = [name for name, element in ELEMENTS.items() if element.long_from]
YOUNG, NU = 1e6, 0.3
every_controlled = pytest.mark.parametrize("name", CONTROLLED)


def arm(name, slenderness, elements, **changes):
    rod = Rod("arm", 1.0, elements, Circle(1.0 / slenderness), SaintVenantKirchhoff(YOUNG, NU), name)
    rod = replace(rod, formulation=ELEMENTS[name].formulations[0], **changes)
    return replace(rod, supports=(Support(0.0, "free_section_clamp"),))


def test_which_elements_are_controlled():
    """Those of two points whose sections can warp; 3333 keeps the shear of its plane sections."""
    assert CONTROLLED == ["3343", "3363"]


@every_controlled
@pytest.mark.parametrize("slenderness", [30, 100, 500, 2000])
@pytest.mark.parametrize("elements", [2, 3, 4, 8])
def test_long_elements_bend_as_the_elastica(name, slenderness, elements):
    """Tip force P L^2/EI = 5: without the control 2 to 8 elements end on limit points, or unstable.

    The mesh error falls with order 4 from 8e-3 (two elements); finite strain adds 1.5 (kappa R)^2.
    """
    EI = YOUNG * np.pi / slenderness**4 / 4
    exact = elastica_tip_force(5.0)
    tip = np.array([1.0 - exact.u, exact.w])
    load = Force("arm", 1.0, np.array([0.0, 5.0 * EI, 0.0]))
    solution = solve(Scene((arm(name, slenderness, elements),), forces=(load,)))
    assert solution.status == "converged" and solution.stable
    error = np.linalg.norm(solution.tip().position[:2] - tip)
    assert error < 8e-3 * (2 / elements) ** 4 + 1.5 * (3.0 / slenderness) ** 2


@every_controlled
def test_a_swelling_that_the_points_miss_costs_what_the_integral_says(name):
    """Sections grown by 1 + a P_2(xi) in y and z: E_yy = E_zz = a P_2 to first order, and with int P_2^2 dx =
    h/5 the control is 2 mu a^2 A h/5 times c = rho h/(h^2 + (k rho)^2), rho = R/2.
    """
    a, R, elements = 1e-6, 0.05, 2
    model = make_rod_model(Scene((arm(name, 1 / R, elements),)), arm(name, 1 / R, elements), 0)
    e = model.e0.copy()
    vectors = model.element.vectors
    for node, P_2 in enumerate((1.0, -0.5, 1.0)):
        for vector in (R_Y, R_Z):
            e[:, node * len(vectors) + vectors.index(vector)] *= 1.0 + a * P_2
    control = model.elastic.control
    assert control is not None
    mu, h, A = YOUNG / (2 * (1 + NU)), 0.5, np.pi * R**2
    c = (R / 2) * h / (h**2 + (ELEMENTS[name].long_from * R / 2) ** 2)
    expected = elements * 2 * mu * a**2 * A * h / 5 * c
    # Second order in a, and the products' differences lose 1e-16/a of their digits.
    assert control.energy(e) == pytest.approx(expected, rel=1e-5)


@every_controlled
def test_each_element_has_the_control_of_its_length(name):
    """Elements of 0.3 and 0.7, met by a pin: the weights c h/45 of each stand in front of one section's H."""
    rod = replace(arm(name, 20, 2), supports=(Support(0.0, "free_section_clamp"), Support(0.3, "pin")))
    model = make_rod_model(Scene((rod,)), rod, 0)
    np.testing.assert_allclose(model.mesh.h, [0.3, 0.7])
    H = model.elastic.control.section.H[:, 0]
    weights = [control_weight(h, 0.025, ELEMENTS[name].long_from) for h in (0.3, 0.7)]  # rho = R/2
    np.testing.assert_allclose(H[0] / weights[0], H[1] / weights[1], rtol=1e-12)


def test_short_elements_are_hardly_controlled():
    """c falls from rho/h in long elements to h/(144 rho) in short ones; it is largest, 1/24, at 12 rho."""
    c = [control_weight(h, 1.0, 12.0) * 45.0 / h for h in (1e4, 12.0, 1e-2)]
    np.testing.assert_allclose(c, [1e-4, 1 / 24, 1e-2 / 144], rtol=1e-5)


@every_controlled
def test_only_strains_of_the_section_are_controlled(name):
    """The second difference over the nodes, of products between directors and of nothing else."""
    element = ELEMENTS[name]
    directors = len(element.directors) - 1
    A = swelling(element)
    assert A.shape == (1, 3, directors * (directors + 1) // 2)
    assert np.all(A[0] == np.array([[1.0], [-2.0], [1.0]]))
    assert NODES.tolist() == list(element.node_xi)
    rod = arm(name, 20, 2)
    control = make_rod_model(Scene((rod,)), rod, 0).elastic.control
    # At the nodes the directors are nodal vectors: the control sees those and no position.
    assert control.N.shape[2] == directors
    assert np.array_equal(np.unique(control.N), [0.0, 1.0])
    assert not np.any(control.N[..., :: len(element.vectors)])


def test_rubber_of_3363_is_controlled_by_its_shear_modulus():
    """nu = .4999: a control by the bulk modulus would lock; the rod bends as at nu = .49."""
    tips = []
    for nu in (0.49, 0.4999):
        rod = arm("3363", 100, 4, material=NeoHookean(YOUNG, nu))
        moment = Moment("arm", 1.0, np.array([0.0, 0.0, 2.0 * YOUNG * np.pi / 4e8]))
        solution = solve(Scene((rod,), moments=(moment,)))
        assert solution.status == "converged"
        tips.append(solution.tip().position)
    assert np.linalg.norm(tips[1] - tips[0]) < 1e-3
