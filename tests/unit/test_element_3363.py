"""Element 3363: no spurious modes, no locking, isotropy, loads, bending against the exact section problem."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given

from ancf.elements import ELEMENTS, R_YY, R_YZ, R_ZZ
from ancf.hyperelastic import MooneyRivlin, NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.predictor import load_start
from ancf.rod_model import make_rod_model
from ancf.rotation import exp
from ancf.scene import Force, Frame, Gravity, LineLoad, Moment, Rod, Scene, Support
from ancf.section_energy import affine_functions, force_weights
from ancf.sections import Annulus, Circle, Ellipse, Polygon, Rectangle
from ancf.solution import Status
from ancf.solver import solve
from reference.section_answer import section_answer
from tests.strategies import draws
from validation import kernel_measures as kernel
from validation.random_rods import bent_state, random_vector

LENGTH, RADIUS = 0.4, 0.01
FREE = (Support(0.0, "free_section_clamp"),)
POLYGON = Polygon(((0.0, 0.0), (0.02, 0.0), (0.02, 0.01), (0.004, 0.016)))
SECTIONS = [Circle(0.01), Annulus(0.01, 0.006), Ellipse(0.012, 0.008), Rectangle(0.02, 0.01), POLYGON]


def rubber(nu, young=1e6):
    mu = young / (2 * (1 + nu))
    return MooneyRivlin(0.35 * mu, 0.15 * mu, young / (3 * (1 - 2 * nu)))


LAWS = {"saint-venant-kirchhoff": SaintVenantKirchhoff, "neo-hookean": NeoHookean}
every_law = pytest.mark.parametrize("law", [SaintVenantKirchhoff, NeoHookean, lambda E, nu: rubber(nu, E)])


def arm(law, section=None, elements=16, **changes):
    section = section or Circle(RADIUS)
    rod = Rod("rod", LENGTH, elements, section, law, element="3363", supports=FREE)
    return replace(rod, **changes)


def couple(degrees, direction=(0.0, 0.0, 1.0)):
    """M = E I theta / L for E = 1e6."""
    return 1e6 * np.pi * RADIUS**4 / 4 * np.radians(degrees) / LENGTH * np.asarray(direction)


@every_law
@pytest.mark.parametrize("section", SECTIONS, ids=lambda s: type(s).__name__)
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.4999])
def test_six_zero_modes(law, section, nu):
    """issue 3: spurious modes examined. Exactly 6 at the reference, for any section, law, Poisson ratio."""
    for elements in (1, 3):
        rod = arm(law(1e6, nu), section, elements)
        model = make_rod_model(Scene((rod,)), rod, 0)
        K = kernel.assembled(model, model.elastic.force_and_tangent(model.e0)[1])
        values = np.sort(np.abs(np.linalg.eigvalsh(K)))
        assert values[5] < 1e-12 * values[-1]
        assert values[6] > 1e2 * values[5]


@every_law
@given(source=draws())
def test_six_zero_modes_when_bent(law, source):
    rod = arm(law(1e6, 0.3), elements=2, supports=())
    model = make_rod_model(Scene((rod,)), rod, 0)
    q = bent_state(model, random_vector(source, 2.0))
    assert kernel.zero_modes(kernel.assembled(model, kernel.strain_tangent(model, q)))[0] == 6


@lru_cache
def exact(law, nu, degrees):
    table = {"law": law, "young_modulus": 1e6, "poisson_ratio": nu}
    section = {"shape": "circle", "radius": RADIUS}
    return np.array(section_answer(table, section, LENGTH, couple(degrees))["position"])


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("nu", [0.3, 0.45, 0.49])
@pytest.mark.parametrize(("degrees", "limit"), [(90, 1.5e-4), (180, 1e-3), (300, 4e-3)])
def test_bending_is_that_of_the_exact_section_problem(law, nu, degrees, limit):
    """issue 3, NUMBERS: 16 elements, L/R = 40, tip within 1e-3 L up to 180 degrees and 4e-3 L up to 300."""
    scene = Scene((arm(LAWS[law](1e6, nu)),), moments=(Moment("rod", 1.0, couple(degrees)),))
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    assert (solution.steps, solution.cutbacks) == (1, 0)
    assert solution.iterations <= 8
    assert np.linalg.norm(solution.tip().position / LENGTH - exact(law, nu, degrees)) < limit


@every_law
@pytest.mark.parametrize("degrees", [90, 300])
def test_nearly_incompressible(law, degrees):
    """nu = .4999 converges in one step, with the tip within 1e-3 L of that at nu = .49.

    With lambda, or U(J), at every section point the same rods are off by 2e-2 and more (theory.md 3).
    """
    tips = []
    for nu in (0.49, 0.4999):
        solution = solve(Scene((arm(law(1e6, nu)),), moments=(Moment("rod", 1.0, couple(degrees)),)))
        assert solution.status is Status.CONVERGED
        assert solution.steps == 1
        assert solution.iterations <= 12
        tips.append(solution.tip().position / LENGTH)
    assert np.linalg.norm(tips[1] - tips[0]) < 1e-3


@every_law
@pytest.mark.parametrize("section", [Circle(RADIUS), Annulus(RADIUS, 0.005)], ids=["circle", "annulus"])
def test_round_sections_bend_alike_in_every_direction(law, section):
    """The projection of the volume ratio knows no axes; four points on a ring err by up to 8e-2 L."""
    tips = []
    for angle in (0.0, np.pi / 8, 1.0):
        A = exp(np.array([angle, 0.0, 0.0]))
        M = couple(180, A @ np.array([0.0, 0.0, 1.0]))
        solution = solve(Scene((arm(law(1e6, 0.49), section),), moments=(Moment("rod", 1.0, 0.9 * M),)))
        tips.append(A.T @ solution.tip().position / LENGTH)
    np.testing.assert_allclose(tips[1:], [tips[0]] * 2, atol=1e-8)


@every_law
def test_inf_sup(law):
    """Bending does not stiffen with the bulk modulus, at any mesh: tip force against beam theory.

    An inf-sup constant that vanished with the mesh or K would show as locking: the small deflection P L^3/3EI
    (clamp free to contract) must stay within 1 % (shear and coarse meshes) for 2 to 32 elements up to .4999.
    """
    section, load = Circle(RADIUS), 1e-6
    for elements in (2, 8, 32):
        for nu in (0.3, 0.49, 0.4999):
            rod = arm(law(1e6, nu), section, elements)
            solution = solve(Scene((rod,), forces=(Force("rod", 1.0, np.array([0.0, load, 0.0])),)))
            thin = load * LENGTH**3 / (3e6 * section.weaker_second_moment)
            shear = load * LENGTH / (1e6 / (2 * (1 + nu)) * section.area)
            found = solution.tip().position[1]
            # Quadratic elements with two points: error P L^3/(12 EI) / (4 n^2) or less (linear curvature).
            assert found == pytest.approx(thin + shear, rel=2e-3 + 0.1 / elements**2)


def test_the_start_is_saint_venants_lateral_field():
    """theory.md 3: v = nu kappa (y^2 - z^2)/2, w = nu kappa y z in bending about z, turned for others."""
    nu, angle = 0.4, 0.7
    law = SaintVenantKirchhoff(1e6, nu)
    A = exp(np.array([angle, 0.0, 0.0]))
    kappa = np.radians(90) / LENGTH
    model = Model(Scene((arm(law),), moments=(Moment("rod", 1.0, couple(90, A[:, 2])),)))
    start = load_start(model)
    assert start is not None
    vectors = ELEMENTS["3363"].vectors
    first = start.reshape(-1, len(vectors), 3)[0]
    y, z = 0.006, -0.004
    eta, zeta = A.T[1:, 1:] @ [y, z]  # along the turned axes
    lateral = nu * kappa * np.array([(eta**2 - zeta**2) / 2, eta * zeta])
    expected = A[1:, 1:] @ lateral
    found = [first[vectors.index(v)] for v in (R_YY, R_YZ, R_ZZ)] @ np.eye(3)
    np.testing.assert_allclose((found.T @ [y**2 / 2, y * z, z**2 / 2])[1:], expected, rtol=1e-10, atol=1e-16)


@pytest.mark.parametrize("section", SECTIONS, ids=lambda s: type(s).__name__)
def test_a_point_force_is_spread_without_changing_its_resultant_and_moment(section):
    """t = sum phi_i(y0, z0) phi_i: weights of 1, y, z are 1, y0, z0; of y^2/2 at the centroid I_z/2A."""
    element = ELEMENTS["3363"]
    weights = force_weights(element, section, 0.004, -0.003)
    np.testing.assert_allclose(weights[:3], [1.0, 0.004, -0.003], rtol=1e-12, atol=1e-16)
    centre = force_weights(element, section, 0.0, 0.0)
    second = section.second_moments / section.area
    np.testing.assert_allclose(centre[3:], [second[0, 0] / 2, second[0, 1], second[1, 1] / 2], atol=1e-17)


def test_affine_functions_are_orthonormal():
    y, z, weight = POLYGON.quadrature(8)
    phi = affine_functions(y, z, weight)
    np.testing.assert_allclose(phi.T @ (weight[:, None] * phi), np.eye(3), atol=1e-12)
    fitted = phi @ (phi.T @ (weight * (2.0 + 3.0 * y - z)))
    np.testing.assert_allclose(fitted, 2.0 + 3.0 * y - z, atol=1e-12)


@every_law
@pytest.mark.parametrize("section", SECTIONS, ids=lambda s: type(s).__name__)
def test_every_load_on_every_section(law, section):
    """Gravity, line load, tip force, follower moment and force on a curved, twisted reference: equilibrium.

    The reaction is the sum of the loads (statics), the section force at the base likewise.
    """
    density, g = 1070.0, np.array([0.0, -2.0, -3.0])
    stiff = law(2e6, 0.45)
    material = type(stiff)(**{**vars(stiff), "density": density})
    rod = arm(
        material,
        section,
        6,
        curvature=np.array([1.0, 0.5, -2.0]),
        base=Frame(np.array([1.0, 2.0, 3.0]), exp(np.array([0.4, 0.2, -0.6]))),
    )
    force, line = np.array([0.02, -0.03, 0.01]), np.array([0.0, 0.1, 0.02])
    scene = Scene(
        (rod,),
        moments=(Moment("rod", 0.5, np.array([1e-3, 2e-3, -1e-3]), direction="follower"),),
        forces=(Force("rod", 1.0, force, np.array([0.002, 0.003])),),
        line_loads=(LineLoad("rod", line),),
        gravity=Gravity(g),
    )
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    weight = density * section.area * LENGTH * g  # the centroid runs along the axis: Pappus
    total = force + line * LENGTH + weight
    np.testing.assert_allclose(solution.reaction()[0], -total, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("law", ["neo-hookean", "saint-venant-kirchhoff"])
def test_a_moment_is_carried_by_every_section(law):
    """The section couple of a tip moment is the moment, at every axial point (theory.md 1), to 1e-3 of it."""
    M = couple(150, (0.4, 0.3, 0.8))
    solution = solve(Scene((arm(LAWS[law](1e6, 0.45)),), moments=(Moment("rod", 1.0, M),)))
    forces = solution.section_forces()
    size = float(np.linalg.norm(M))
    np.testing.assert_allclose(forces.moment, np.tile(M, (len(forces.x), 1)), atol=1e-3 * size)
    np.testing.assert_allclose(forces.moment.mean(axis=0), M, atol=2e-5 * size)
    np.testing.assert_allclose(forces.force, 0.0, atol=1e-9 * size / RADIUS)
