"""Derivatives of the section energy, its shape functions, and its tangents, against differences."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from reference.rotation import exp, exp_integral
from reference.section import SectionState, bend, bend_and_twist, coupled_tangent, tangent, twist
from reference.section_form import SectionForm
from reference.section_newton import SectionLoad, bordered_tangent
from reference.section_shapes import SectionShapes
from reference.solid_materials import MooneyRivlin, NeoHookean, SaintVenantKirchhoff
from reference.solid_mesh import circular_section, rectangular_section

R, E = 0.01, 1e6  # m, Pa
EI, GJ = E * np.pi * R**4 / 4, E / 2.6 * np.pi * R**4 / 2
COARSE = circular_section(R, 1, 1)
SVK = SaintVenantKirchhoff(E, 0.3)
LAWS = [SVK, NeoHookean(E, 0.3), MooneyRivlin(1e5, 6e4, 3e7)]


def _strained(form: SectionForm, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    u, e = form.straight
    return u + 0.01 * random.normal(size=u.shape), e + 0.1 * random.normal(size=e.shape)


@pytest.mark.parametrize("law", LAWS, ids=str)
@pytest.mark.parametrize("mixed", [False, True])
@pytest.mark.parametrize("order", [2, 4])
def test_gradient_and_tangent_of_the_energy(law: SaintVenantKirchhoff, mixed: bool, order: int) -> None:
    """Central differences along one direction; error of the difference about 1e-10."""
    form = SectionForm(COARSE, law, mixed, order)
    u, e = _strained(form)
    way = np.random.default_rng(1).normal(size=form.unknowns)
    step = 1e-5
    du, de = step * way[:-7].reshape(u.shape), step * way[-7:]
    more, less, here = form.forces(u + du, e + de), form.forces(u - du, e - de), form.forces(u, e)
    assert (more.energy - less.energy) / (2 * step) == pytest.approx(here.gradient @ way, rel=1e-7)
    change = here.tangent @ way
    assert_allclose((more.gradient - less.gradient) / (2 * step), change, atol=1e-6 * np.abs(change).max())
    assert abs(here.tangent - here.tangent.T).max() < 1e-12 * abs(here.tangent).max()
    straight = form.forces(*form.straight)
    assert straight.energy == pytest.approx(0.0, abs=1e-15)
    assert_allclose(straight.gradient, 0.0, atol=1e-10)


def test_deformation_gradient_is_that_of_the_screw() -> None:
    """F of the formula against differences of x(s, Y) = r(s) + S(s) u(Q(s) Y) along s, u quadratic in Y."""
    form = SectionForm(COARSE, SVK, False, 4)
    e = np.array([1.1, 0.05, -0.07, 0.3, -0.2, 0.4, 0.25])
    a, k, spin = e[:3], e[3:6], e[6]

    def field(Y: np.ndarray) -> np.ndarray:
        y, z = Y[..., 0], Y[..., 1]
        return np.stack([0.1 * y * z, y + 0.2 * y**2, 1.1 * z - 0.1 * y * z], axis=-1)

    # the quadratic field in the coefficients of order 4, by least squares at the integration points
    phi = form.phi.reshape(-1, form.phi.shape[-1])
    matrix = np.zeros((len(phi), len(form.Y)))
    n_qp = form.phi.shape[1]
    for row, values in enumerate(phi):
        np.add.at(matrix[row], form.elements[row // n_qp], values)
    points = form.shapes.points
    u = np.asarray(np.linalg.lstsq(matrix, field(points).reshape(-1, 3), rcond=None)[0], np.float64)

    def position(s: float, Y: np.ndarray) -> np.ndarray:
        turned = Y @ exp([s * spin, 0, 0])[1:, 1:].T
        return s * exp_integral(s * k) @ a + field(turned) @ exp(s * k).T

    h = 1e-4
    F = form.deformation_gradient(u, e)
    ahead = (position(h, points) - position(-h, points)) / (2 * h)
    assert_allclose(F[..., 0], ahead, atol=1e-7)
    for i in range(2):
        shift = h * np.eye(2)[i]
        across = (position(0.0, points + shift) - position(0.0, points - shift)) / (2 * h)
        assert_allclose(F[..., i + 1], across, atol=1e-9)


@pytest.mark.parametrize("order", [2, 3, 4, 6])
def test_shape_functions(order: int) -> None:
    section = circular_section(R, 2, 1)
    shapes = SectionShapes(section, R, order)
    assert_allclose(shapes.phi @ shapes.coordinates[shapes.elements], shapes.points, atol=1e-12)
    assert shapes.weights.sum() == pytest.approx(section.area / R**2, rel=1e-13)
    y_slope = shapes.phi_y @ shapes.coordinates[shapes.elements]
    assert_allclose(y_slope, np.broadcast_to([1.0, 0.0], y_slope.shape), atol=1e-10)


def test_order_6_holds_cubic_fields_across_curved_quads() -> None:
    """y^3 on a biquadratic quad has degree 6; edges with odd functions must agree between quads."""
    shapes = SectionShapes(circular_section(R, 3, 2), R, 6)
    target = shapes.points[..., 0] ** 3 - shapes.points[..., 0] * shapes.points[..., 1] ** 2
    weighted = shapes.phi * shapes.weights[..., None]
    mass = np.zeros((shapes.count, shapes.count))
    np.add.at(
        mass, (shapes.elements[:, :, None], shapes.elements[:, None]), weighted.swapaxes(1, 2) @ shapes.phi
    )
    field = np.linalg.solve(mass, shapes.gather(weighted * target[..., None]))
    assert_allclose((shapes.phi @ field[shapes.elements][..., None])[..., 0], target, atol=1e-10)


def test_odd_edge_functions_are_continuous_whatever_the_numbering() -> None:
    """Two quads whose common edge runs in opposite local directions share the values on it."""
    section = rectangular_section(R, R, 2)
    shapes = SectionShapes(section, R, 5)
    corners = shapes.mesh.t
    signs = shapes.signs
    for edge, (start, end) in enumerate([(0, 1), (1, 2), (3, 2), (0, 3)]):
        backwards = corners[start] > corners[end]
        odd = signs[:, 4 + 4 * edge + 1]
        assert_allclose(odd, np.where(backwards, -1.0, 1.0))
        assert_allclose(signs[:, 4 + 4 * edge], 1.0)


def test_pressure_is_foreseen_to_second_order() -> None:
    form = SectionForm(COARSE, NeoHookean(E, 0.49), True, 2)
    u, e = _strained(form)
    way = np.random.default_rng(5).normal(size=form.unknowns)
    here = form.forces(u, e)
    errors = []
    for step in (1e-4, 5e-5):
        there = form.forces(u + step * way[:-7].reshape(u.shape), e + step * way[-7:])
        foreseen = form.predict_pressure(here, step * way)
        assert foreseen is not None
        errors.append(np.abs(there.pressure - foreseen).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize("law", [SVK, NeoHookean(E, 0.4999)], ids=["svk", "rubber"])
@pytest.mark.parametrize("kind", ["bending", "torsion"])
def test_tangent_of_bending_and_torsion(law: SaintVenantKirchhoff, kind: str) -> None:
    """dM/dk against central differences with one extrapolation (error 1e-9)."""
    start, axis, solve = (12.0, 2, bend) if kind == "bending" else (40.0, 0, twist)

    def couple(k: float) -> float:
        return float(solve(COARSE, law, k).couple[axis])

    def slope(h: float) -> float:
        return (couple(start + h) - couple(start - h)) / (2 * h)

    matrix = tangent(solve(COARSE, law, start))
    h = 0.02 * start
    assert matrix[axis, axis] == pytest.approx((4 * slope(h / 2) - slope(h)) / 3, rel=2e-7)
    assert_allclose(matrix, matrix.T, atol=1e-11 * abs(matrix).max())


def test_tangent_across_the_bending_is_the_secant() -> None:
    """The couple turns with the axis of bending of an isotropic bar: dM_y/dk_y = M/kappa."""
    state = bend(circular_section(R, 2), SVK, curvature=12.0)
    assert tangent(state)[1, 1] == pytest.approx(state.couple[2] / 12.0, rel=1e-6)


def test_tangent_of_the_straight_bar() -> None:
    matrix = tangent(twist(circular_section(R, 2), SVK, twist=0.0))
    assert_allclose(matrix, np.diag([GJ, EI, EI]), atol=1e-6 * EI)


def test_coupled_tangent() -> None:
    """Compliance of (twist, curvature) by (M_t, M_b) against central differences."""
    moment = EI * np.array([3.0, 0.0, 8.0])

    def strain(M: np.ndarray) -> np.ndarray:
        state = bend_and_twist(COARSE, SVK, M)
        return np.array([state.twist, state.curvature])

    h = 0.02 * EI
    columns = [(strain(moment + h * d) - strain(moment - h * d)) / (2 * h) for d in np.eye(3)[[0, 2]]]
    matrix = coupled_tangent(bend_and_twist(COARSE, SVK, moment))
    assert_allclose(matrix @ np.array(columns).T, np.eye(2), atol=3e-7)
    assert abs(matrix[0, 1]) > 1e-3 * EI
    thin = coupled_tangent(bend_and_twist(circular_section(R, 2), SVK, 1e-3 * moment))
    assert_allclose(thin, np.diag([GJ, EI]), atol=1e-5 * EI)
    with pytest.raises(ValueError, match="needs one of bend_and_twist"):
        coupled_tangent(bend(COARSE, SVK, curvature=1.0))


def test_multipliers_vanish_in_equilibrium() -> None:
    """No hidden force holds the frame: the whole bar is in equilibrium."""
    state: SectionState = bend_and_twist(COARSE, SVK, EI * np.array([3.0, 1.0, 8.0]))
    assert_allclose(state.point.multiplier, 0.0, atol=1e-12)
    assert state.residual < 1e-13
    assert_allclose(state.force, 0.0, atol=1e-12 * E * R**2)


def test_bordered_tangent_keeps_what_is_held() -> None:
    form = SectionForm(COARSE, SVK, False, 2)
    held = np.array([False, False, False, True, True, True, True])
    load = SectionLoad(held, np.arange(7.0))
    matrix = bordered_tangent(form, form.forces(*form.straight).tangent, load).toarray()
    rows = matrix[form.unknowns - 4 : form.unknowns]
    assert_allclose(rows[:, form.unknowns - 4 : form.unknowns], np.eye(4), atol=0)
    assert np.count_nonzero(rows) == 4
    assert_allclose(load.part(0.25).value, [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5])
