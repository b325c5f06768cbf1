"""The whole system: B_1, B_2, tangent, potential, floor, effects that are not listed."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ancf import rod_model
from ancf.elements import ELEMENTS, SECTION_ELEMENTS
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.scene import Force, Frame, Gravity, LineLoad, Moment, Rod, Scene, SolverOptions, Support
from ancf.scene_effects import EFFECT_MODULES
from ancf.sections import Circle, Rectangle
from tests.strategies import draws, fewer
from validation import kernel_measures as kernel
from validation.property_examples import SOLVED
from validation.random_rods import random_loads, random_rod, random_rotation, random_state

every_element = pytest.mark.parametrize("name", ELEMENTS)
every_section = pytest.mark.parametrize("name", SECTION_ELEMENTS)
DEAD = ("force", "line_load", "gravity")


def random_q(source, model):
    """Strained coordinates (n,) of a model with one rod."""
    return random_state(source, model.rods[0]).ravel()


def dense_tangent(model, q, load_factor):
    """K (n, n) by central differences of the residual of the whole system, one unknown after the other."""
    K = np.empty((model.n, model.n))
    for j in range(model.n):
        t = 6e-6 * model.unit[j]
        ahead, behind = q.copy(), q.copy()
        ahead[j] += t
        behind[j] -= t
        change = model.residual(ahead).at(load_factor) - model.residual(behind).at(load_factor)
        K[:, j] = change / (ahead[j] - behind[j])
    return K


def two_rods(name="3333", **options):
    """A clamped and a pinned rod with every kind of load."""
    material = SaintVenantKirchhoff(1e6, 0.3, 1000.0)
    turned = Frame(np.array([1.0, 2.0, 3.0]), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    a = Rod("a", 1.0, 3, Circle(0.05), material, element=name, supports=(Support(0.0, "free_section_clamp"),))
    b = Rod("b", 2.0, 4, Rectangle(0.1, 0.2), material, element=name, base=turned,
            supports=(Support(0.0, "pin"), Support(0.5, "clamp")))  # fmt: skip
    return Scene(
        (a, b),
        moments=(
            Moment("a", 1.0, np.array([0.3, -0.2, 0.5])),
            Moment("b", 0.25, np.array([3.0, 1.0, -2.0]), "follower", "vorticity"),
        ),
        forces=(
            Force("b", 1.0, np.array([5.0, 3.0, -2.0]), np.array([0.03, -0.05]), "follower"),
            Force("a", 0.6, np.array([0.4, 0.1, 0.2]), np.array([0.0, 0.02])),
        ),
        line_loads=(
            LineLoad("a", np.array([0.1, 0.2, 0.3]), "follower"),
            LineLoad("b", np.array([1.0, -2.0, 0.5])),
        ),
        gravity=Gravity(np.array([0.0, 0.1, -0.3])),
        solver=SolverOptions(**options),
    )


@every_section
@settings(max_examples=fewer(4))
@given(source=draws(), load_factor=st.floats(0.1, 2.0))
def test_supported_tangent_is_the_difference_tangent_on_the_free_unknowns(name, source, load_factor):
    """B_2^T K B_2 of paper eq. 10, 38, all kinds of load; differences err by 1e-8 of K."""
    rod = replace(random_rod(source, name, SOLVED), elements=2)
    model = Model(random_loads(source, rod, 2.0))
    q = random_q(source, model)
    B = model.boundary_matrix().toarray()
    scale = (B.T @ model.unit)[:, None] * (B.T @ model.unit)
    expected = B.T @ dense_tangent(model, q, load_factor) @ B
    found = model.supported_tangent(q, load_factor).toarray()
    np.testing.assert_allclose(found * scale, expected * scale, atol=1e-6 * np.abs(expected * scale).max())


@every_section
def test_two_rods_assemble_without_touching_each_other(name):
    model = Model(two_rods(name))
    rng = np.random.default_rng(5)
    q = model.q0 + 0.02 * model.unit * rng.uniform(-1, 1, model.n)
    B = model.boundary_matrix().toarray()
    K = model.supported_tangent(q, 0.7).toarray()
    expected = B.T @ dense_tangent(model, q, 0.7) @ B
    np.testing.assert_allclose(K, expected, atol=1e-7 * np.abs(expected).max())
    first = model.rods[0].size - model.supports[0].rows.shape[0]
    assert not K[:first, first:].any()
    assert not K[first:, :first].any()
    assert model.unknowns == len(K)


@every_section
def test_numerical_tangent_option_gives_the_same_matrix(name):
    """`tangent = "finite-difference"`: central differences of the blocks (paper eq. 38-41)."""
    analytic, numerical = Model(two_rods(name)), Model(two_rods(name, tangent="finite-difference"))
    q = analytic.q0 + 0.02 * analytic.unit * np.random.default_rng(6).uniform(-1, 1, analytic.n)
    forces, a = analytic.residual_and_tangent(q, 0.7)
    other, b = numerical.residual_and_tangent(q, 0.7)
    np.testing.assert_allclose(b, a, atol=1e-8 * np.abs(a).max())
    plain = analytic.residual(q)
    for found in (forces, other):
        np.testing.assert_array_equal(found.Q_ext, plain.Q_ext)
        np.testing.assert_allclose(found.Q_int, plain.Q_int, atol=1e-13 * np.abs(plain.Q_int).max())


@every_section
@pytest.mark.parametrize("tangent", ["analytic", "finite-difference"])
def test_a_rod_in_pieces_is_the_rod(name, tangent, monkeypatch):
    """Kernels that run over a few elements at a time give what they give at once."""
    scene = two_rods(name, tangent=tangent)
    whole = Model(scene)
    q = whole.q0 + 1e-2 * whole.unit * np.random.default_rng(3).standard_normal(whole.n)
    q_previous = whole.q0 + 0.5 * (q - whole.q0)
    wanted, K = whole.residual_and_tangent(q, 0.7, q_previous)
    monkeypatch.setattr(rod_model, "PIECE", 2)
    pieces = Model(scene)
    assert [len(rod.pieces) for rod in whole.rods] == [1, 1]
    assert len(pieces.rods[1].pieces) == 2  # its elements are alike, those of the other rod are not
    found, K_pieces = pieces.residual_and_tangent(q, 0.7, q_previous)
    for one, other in ((wanted.Q_int, found.Q_int), (wanted.Q_ext, found.Q_ext), (K, K_pieces)):
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-13 * np.abs(one).max())


@every_section
@given(source=draws(), load_factor=st.floats(0.1, 2.0))
def test_dead_loads_are_the_gradient_of_the_potential(name, source, load_factor):
    """g = d(U + l V)/dq for gravity, dead forces and dead line loads; order 2 of the differences."""
    # A law of degree 4 in q: its differences have a t^2 term and no other. Rubber: test_hyperelastic.py.
    allowed = replace(SOLVED, laws=("saint-venant-kirchhoff",))
    model = Model(random_loads(source, random_rod(source, name, allowed), 2.0, DEAD))
    q, dq = random_q(source, model), random_q(source, model) - model.q0
    g = model.residual(q).at(load_factor)

    def potential(x):
        value = model.potential(x, load_factor)
        assert value is not None
        return np.array(value)

    order, error = kernel.difference_order(potential, q, dq, np.array(g @ dq))
    assert abs(order - 2.0) < 0.2
    assert error < 1e-8


def test_moments_and_followers_have_no_potential():
    """theory.md 4: a moment fixed in space has no potential; its tangent is unsymmetric."""
    scene = two_rods()
    for one in (
        replace(scene, forces=(), line_loads=()),
        replace(scene, moments=(), line_loads=(), forces=scene.forces[:1]),
        replace(scene, moments=(), forces=(), line_loads=scene.line_loads[:1]),
    ):
        model = Model(one)
        assert model.potential(model.q0) is None
        q = model.q0 + 0.02 * model.unit * np.random.default_rng(1).uniform(-1, 1, model.n)
        K = model.supported_tangent(q, 1.0).toarray()
        without = model.supported_tangent(q, 0.0).toarray()
        assert np.abs(K - K.T).max() > 1e-3 * np.abs(K - without).max()
        np.testing.assert_allclose(without, without.T, atol=1e-13 * np.abs(without).max())


@every_section
@given(source=draws())
def test_b1_picks_the_element_and_b2_the_allowed_motions(name, source):
    """Paper eq. 10: e = B_1 q; dq = B_2 dp with orthonormal columns; the projector of the solver is B_2
    B_2^T.
    """
    model = Model(Scene((random_rod(source, name, SOLVED),)))
    q = random_q(source, model)
    rod = model.rods[0]
    for element in range(len(rod.dofs)):
        e = model.connectivity_matrix(0, element) @ q
        np.testing.assert_array_equal(
            e.reshape(-1, 3), kernel.per_element(rod, q.reshape(rod.q0.shape))[element]
        )
    B = model.boundary_matrix().toarray()
    assert B.shape == (model.n, model.unknowns)
    np.testing.assert_allclose(B.T @ B, np.eye(model.unknowns), atol=1e-13)
    np.testing.assert_allclose(model.system.project(np.eye(model.n)), B @ B.T, atol=1e-13)
    for s in model.supports:
        np.testing.assert_allclose(s.rows @ B[s.dofs], 0.0, atol=1e-13)


@every_section
def test_the_linear_solve_is_the_reduced_one(name):
    """Projected band LU against a dense solve with B_2, on supports that couple components."""
    model = Model(two_rods(name))
    q = model.q0 + 0.02 * model.unit * np.random.default_rng(2).uniform(-1, 1, model.n)
    forces, flat = model.residual_and_tangent(q, 0.7)
    g = forces.at(0.7)
    dq = model.system.solve(model.system.factorise(flat), -g)
    B = model.boundary_matrix().toarray()
    expected = B @ np.linalg.solve(model.supported_tangent(q, 0.7).toarray(), -B.T @ g)
    np.testing.assert_allclose(
        dq / model.unit, expected / model.unit, atol=1e-9 * np.abs(expected / model.unit).max()
    )


def test_units_make_the_model_dimensionless():
    """Lengths by L, slopes by 1; forces by E I / L^2, their slopes' by E I / L (theory.md 6)."""
    model = Model(two_rods("3243"))
    rod = model.rods[1]
    I = 0.2 * 0.1**3 / 12  # noqa: E741 the smaller one, h w^3 / 12
    here = slice(rod.first_dof, rod.first_dof + 12)
    np.testing.assert_allclose(model.unit[here], [2.0] * 3 + [1.0] * 9)
    np.testing.assert_allclose(model.force_unit[here], [1e6 * I / 4] * 3 + [1e6 * I / 2] * 9)
    assert rod.rod.section.radius_of_gyration == pytest.approx(0.1 / np.sqrt(12), rel=1e-12)


@every_section
def test_row_sum_bounds_the_residual_of_a_rounded_state(name):
    """|K| |q| at the worst equation, against the dense sum, dimensionless."""
    model = Model(two_rods(name))
    q = model.q0 + 0.01 * model.unit
    _, flat = model.residual_and_tangent(q, 0.0)
    b, n = model.pattern.b, model.n
    dense = np.zeros((n, n))
    i, j = np.nonzero(np.abs(np.subtract.outer(np.arange(n), np.arange(n))) <= b)
    dense[i, j] = flat[model.pattern.slots(i, j)]
    expected = np.max(np.abs(dense) @ np.abs(q) / model.force_unit)
    assert model.system.row_sum(flat, q) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("field", EFFECT_MODULES)
def test_only_listed_effects_are_imported(field):
    """architecture.md: what is not listed is not built, not imported, not called."""
    loads = {
        "moments": "moments=(Moment('rod', 1.0, np.ones(3)),)",
        "forces": "forces=(Force('rod', 1.0, np.ones(3)),)",
        "line_loads": "line_loads=(LineLoad('rod', np.ones(3)),)",
        "line_moments": "line_moments=(LineMoment('rod', np.ones(3)),)",
        "gravity": "gravity=Gravity(np.ones(3))",
        "magnets": "magnets=(Magnet('rod', np.ones(3), np.ones(3)),)",
        "tendons": "tendons=(Tendon('rod', 1.0, np.array([[0, 0.05, 0], [1, 0.05, 0]])),)",
        "pressures": "pressures=(Pressure('rod', 1e3, np.zeros(2), 0.05),)",
        "springs": "springs=(Spring('rod', 1.0, np.eye(3)),)",
        "foundations": "foundations=(Foundation('rod', np.ones(3)),)",
        "contacts": "contacts=(Contact('rod', Sphere(np.full(3, 9.0), 1.0)),)",
    }
    code = f"""
import sys, numpy as np, ancf
from ancf.scene import *
from ancf.sections import Circle
from ancf.obstacles import Sphere
from ancf.materials import SaintVenantKirchhoff
rod = Rod('rod', 1.0, 2, Circle(0.1), SaintVenantKirchhoff(1e9, 0.3, 1.0))
solution = ancf.solve(Scene((rod,), {loads[field]}))
print(sorted(m.removeprefix('ancf.effects.') for m in sys.modules if m.startswith('ancf.effects.')))
print(sorted(solution.effects))
"""
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    module = EFFECT_MODULES[field]
    assert out.splitlines() == [str([module]), str(sorted(["elastic", module]))]


@given(draws())
def test_gravity_weighs_the_whole_rod(source):
    """sum of the weight over the nodes = rho g V, V = A L also for curved rods (Pappus: the centroid is on
    the axis).

    Linear interpolation of turning section vectors shrinks the area by turn^2/6 an element, of a chord its
    length by
    turn^2/24.
    """
    for name in ELEMENTS:
        rod = random_rod(source, name)
        g = random_rotation(source)[0]
        model = Model(Scene((rod,), gravity=Gravity(g)))
        Q = model.residual(model.q0).Q_ext.reshape(model.rods[0].q0.shape)[:, 0].sum(axis=0)
        weight = (rod.material.density or 0.0) * rod.section.area * rod.length
        turn = np.linalg.norm(rod.curvature) * rod.length / rod.elements
        np.testing.assert_allclose(Q, weight * g, atol=(1e-12 + turn**2 / 4) * weight)


@given(draws())
def test_point_and_line_forces_add_up(source):
    """A force has its own resultant and its moment about the base; a line load f L, half of it at L/2 if
    straight.
    """
    for name in SECTION_ELEMENTS:  # offsets and followers
        rod = replace(random_rod(source, name), curvature=np.zeros(3))
        F, y, z = random_rotation(source)[0], 0.3 * rod.section.outer_radius, -0.2 * rod.section.outer_radius
        at = source.number(0.0, 1.0)
        for load in (
            {"forces": (Force("rod", at, F, np.array([y, z])),)},
            {"forces": (Force("rod", at, F, np.array([y, z]), "follower"),)},
            {"line_loads": (LineLoad("rod", F / rod.length),)},
            {"line_loads": (LineLoad("rod", F / rod.length, "follower"),)},
        ):
            model = Model(Scene((rod,), **load))
            Q = model.residual(model.q0).Q_ext.reshape(model.rods[0].q0.shape)
            arm = rod.base.rotation @ (
                np.array([at * rod.length, y, z]) if "forces" in load else [rod.length / 2, 0, 0]
            )
            np.testing.assert_allclose(Q[:, 0].sum(axis=0), F, atol=1e-12)
            np.testing.assert_allclose(
                np.cross(model.rods[0].q0, Q).sum(axis=(0, 1)), np.cross(arm, F), atol=1e-12 * rod.length
            )


def velocity(rod, of):
    """Nodal vectors of a velocity field; `of(order, x)` is its derivative of that order at x."""
    return np.array([[of(order, x) for order in rod.element.vectors] for x in rod.mesh.node_x])


@every_section
def test_a_line_load_is_consistent(name):
    """Its power on the velocity c x^2 e is f . e c L^3/3, which lumping at nodes or midpoints misses."""
    rod = Rod("rod", 2.0, 3, Circle(0.1), SaintVenantKirchhoff(1.0, 0.3), element=name)
    f, e, c = np.array([0.3, -0.7, 0.2]), np.array([0.1, 0.5, -0.4]), 0.8
    powers = {(0, 0, 0): lambda x: c * x**2, (1, 0, 0): lambda x: 2 * c * x}
    for direction in ("fixed", "follower"):
        model = Model(Scene((rod,), line_loads=(LineLoad("rod", f, direction),)))
        dq = velocity(model.rods[0], lambda order, x: e * powers.get(order, lambda x: 0.0)(x))
        power = model.residual(model.q0).Q_ext @ dq.ravel()
        assert power == pytest.approx(f @ e * c * 2.0**3 / 3, rel=1e-12)


@every_section
def test_weight_of_a_curved_rod_lies_outside_its_axis(name):
    """det J_0 = 1 - kappa_z y + kappa_y z: the power on dr_y = e is -rho g . e kappa_z I_z L, and likewise on
    r_z.

    1 % : the interpolated reference follows the arc to (turn an element)^2/24.
    """
    kappa_y, kappa_z, density = 0.4, -0.7, 3.0
    rod = Rod(
        "rod", 1.0, 4, Rectangle(0.3, 0.2), SaintVenantKirchhoff(1.0, 0.3, density), element=name,
        curvature=np.array([0.0, kappa_y, kappa_z]),
    )  # fmt: skip
    g, e = np.array([0.3, -0.7, 0.2]), np.array([0.1, 0.5, -0.4])
    model = Model(Scene((rod,), gravity=Gravity(g)))
    Q = model.residual(model.q0).Q_ext
    I_z, I_y = 0.3**3 * 0.2 / 12, 0.3 * 0.2**3 / 12
    for moved, expected in (((0, 1, 0), -kappa_z * I_z), ((0, 0, 1), kappa_y * I_y)):
        dq = velocity(model.rods[0], lambda order, x, moved=moved: e * (order == moved))
        assert Q @ dq.ravel() == pytest.approx(density * g @ e * expected, rel=1e-2)
