"""Distributed couples: line moments and magnets against closed forms, derivatives, balance, refusals."""

import numpy as np
import pytest

import ancf
from ancf.effects.magnet import MU_0
from ancf.model import Model
from tests.effect_checks import check_derivatives

L, RADIUS, YOUNG = 0.4, 0.004, 1e6
EI, AREA = YOUNG * np.pi * RADIUS**4 / 4, np.pi * RADIUS**2


def scene(rod=None, **tables):
    data = {
        "length": L, "elements": 12, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3, "density": 1000.0},
    } | (rod or {})  # fmt: skip
    return ancf.scene_from_dict({"rod": [data], **tables})


def line_moment(value, **keys):
    return {"line_moment": [{"value": list(value), **keys}]}


def magnet(remanence, field, **keys):
    return {"magnet": [{"remanence": list(remanence), "field": list(field), **keys}]}


@pytest.mark.parametrize("direction", ["fixed", "follower"])
def test_a_line_moment_bends_to_a_parabola_of_angle(direction):
    """M(x) = m (L - x) in the plane, so theta(x) = m (L x - x^2/2)/(E I); the tip by quadrature."""
    m = 1.0 * EI / L**2
    solution = ancf.solve(scene(**line_moment([0, 0, m], direction=direction)))
    x = (np.arange(20000) + 0.5) * L / 20000
    theta = m * (L * x - x**2 / 2) / EI
    exact = [np.mean(np.cos(theta)) * L, np.mean(np.sin(theta)) * L, 0.0]
    assert solution.status == "converged" and solution.steps == 1
    np.testing.assert_allclose(solution.tip().position, exact, rtol=0, atol=5e-4 * L)
    np.testing.assert_allclose(solution.reaction()[1], [0, 0, -m * L], rtol=0, atol=1e-8 * m * L)


def test_a_line_moment_is_many_point_moments():
    """In space, with torsion: the limit of point moments at the middle of each element, of second order."""
    value = np.array([0.5, 1.0, -0.8]) * EI / L**2
    spread = ancf.solve(scene(**line_moment(value))).tip().position
    n = 12
    points = [{"at": (i + 0.5) / n, "value": (value * L / n).tolist()} for i in range(n)]
    lumped = ancf.solve(scene({"elements": 2 * n}, moment=points)).tip().position
    np.testing.assert_allclose(lumped, spread, rtol=0, atol=2e-3 * L)


def test_a_magnetic_catheter_turns_towards_the_field():
    """E I theta'' = -(B_r B A/mu_0) sin(phi - theta), clamped and free: by collocation (scipy, thin rod)."""
    from scipy.integrate import solve_bvp

    B_r, B, phi = 0.1, 0.004, 2.0
    couple = B_r * B * AREA / MU_0
    exact = solve_bvp(
        lambda x, y: np.array([y[1], -couple / EI * np.sin(phi - y[0])]),
        lambda a, b: np.array([a[0], b[1]]),
        np.linspace(0, L, 201), np.linspace([0, phi / L], [phi, 0], 201).T, tol=1e-10,
    )  # fmt: skip
    x = (np.arange(20000) + 0.5) * L / 20000
    theta = exact.sol(x)[0]
    tip = [np.mean(np.cos(theta)) * L, np.mean(np.sin(theta)) * L, 0.0]
    field = B * np.array([np.cos(phi), np.sin(phi), 0.0])
    solution = ancf.solve(scene(**magnet([B_r, 0, 0], field)))
    assert solution.status == "converged" and solution.stable
    assert theta[-1] > 0.8
    np.testing.assert_allclose(solution.tip().position, tip, rtol=0, atol=1e-3 * L)
    force, _ = solution.reaction()
    np.testing.assert_allclose(force, 0.0, atol=1e-9 * EI / L**2)


def test_a_magnet_along_the_field_stays():
    """Stable along the field, unstable against it from a couple of E I (pi/2)^2/L^2 (linear theory)."""
    critical = EI * (np.pi / 2 / L) ** 2 * MU_0 / (0.1 * AREA)
    along = ancf.solve(scene(**magnet([0.1, 0, 0], [2 * critical, 0, 0])))
    below = ancf.solve(scene(**magnet([0.1, 0, 0], [-0.99 * critical, 0, 0])))
    above = ancf.solve(scene(**magnet([0.1, 0, 0], [-1.01 * critical, 0, 0])))
    assert (along.stable, below.stable, above.stable) == (True, True, False)


CASES = {
    "fixed": line_moment([0.3, 1.0, -0.4]),
    "follower": line_moment([0.3, 1.0, -0.4], direction="follower", frame="body"),
    "magnet": magnet([0.1, 0.03, -0.02], [0.01, 0.02, 0.03]),
}


@pytest.mark.parametrize("element", ["3333", "3243", "3363"])
@pytest.mark.parametrize("name", CASES)
def test_tangents_are_derivatives(name, element):
    """K = dQ/de by central differences at a random state; Q = -dV/de where there is a potential."""
    model = Model(scene({"element": element, "elements": 4, "curvature": [0.3, 1.0, -0.5]}, **CASES[name]))
    check_derivatives(model, strain=0.02, step=1e-5)
    assert model.conservative == (name == "magnet")


def test_couples_add_up():
    """sum d_k x Q_k of all sections is the integral of the couple, and no force (moment identity)."""
    model = Model(scene(**line_moment([0.3, 1.0, -0.4])))
    (effect,) = model.effects
    e = model.q0[effect.dofs].reshape(len(effect.dofs), -1, 3)
    Q = effect.force(e)
    np.testing.assert_allclose(np.cross(e, Q).sum(axis=(0, 1)), np.array([0.3, 1.0, -0.4]) * L, rtol=1e-12)
    np.testing.assert_allclose(Q[:, ::3], 0.0, atol=1e-15)


@pytest.mark.parametrize("tables", [line_moment([0, 0, 0]), magnet([0.1, 0, 0], [0, 0, 0])])
def test_nothing_changes_nothing(tables):
    force = {"force": [{"value": [0, 0.5 * EI / L**2, 0]}]}
    np.testing.assert_array_equal(ancf.solve(scene(**force, **tables)).q, ancf.solve(scene(**force)).q)


def test_units_and_refusals():
    loaded = scene(**line_moment(["3 N mm/m", 0, 0]), **magnet([0, 0, "100 mT"], ["5 mT", 0, 0]))
    assert loaded.line_moments[0].value[0] == pytest.approx(3e-3)
    assert loaded.magnets[0].remanence[2] == pytest.approx(0.1)
    for bad in (line_moment([0, 0]), line_moment([0, 0, 0], rod="leg"), magnet([0, 0, 0], ["5 N", 0, 0])):
        with pytest.raises(ancf.SceneError):
            scene(**bad)
