"""Tendons of controlled length with friction: closed form, back from a tension, exact derivatives, slack."""

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

import ancf
from ancf.coupled_system import CoupledSystem
from ancf.model import Model
from ancf.tendon_length import TendonLength
from ancf.tendon_rubbing_length import RubbingTendonLength
from reference.actuation import frictional_arc, frictional_curvature, tendon_rod_of_length
from tests.tendon_scenes import EI, RADIUS, YOUNG, D, L, scene, tendon

STRAIGHT = [[0.0, D, 0.0], [1.0, D, 0.0]]
PATH = [[0.05, D, 0.0], [0.33, 0.0, 0.6 * D], [0.5, -0.5 * D, 0.0], [0.9, -0.5 * D, 0.4 * D]]


@pytest.mark.parametrize("friction", [0.1, 0.5, 2.0])
@pytest.mark.parametrize("element", ["3333", "3343"])
def test_a_length_bends_the_rod_to_a_spiral(element, friction):
    """Closed form of thin rods (reference/actuation.py); the axis is shorter by up to T/(E A) = 2e-4."""
    wanted = L - 3e-4 * L
    solution = ancf.solve(
        scene([tendon(length=wanted, friction=friction)], {"element": element, "elements": 12})
    )
    assert solution.status == "converged" and solution.steps == 1 and solution.stable is None
    (state,) = solution.tendons
    kappa = frictional_curvature(L, wanted, D, RADIUS / 2, friction)
    assert state.length == pytest.approx(wanted, abs=1e-12 * L)
    # 3333 stiffens where its clamp stops the section from contracting: 2.5e-4 without friction.
    assert state.tension == pytest.approx(EI * kappa / D, rel=2e-3)
    # Whatever the friction, the tip turns by what the cable is short of.
    turn = (L - wanted) / (D + RADIUS**2 / (4 * D))
    assert state.end_tension == pytest.approx(state.tension * np.exp(-friction * turn), rel=1e-3)
    assert np.linalg.norm(solution.tip().position - frictional_arc(L, kappa, friction)) <= 3e-4 * L
    assert solution.as_dict()["tendons"][0]["end_tension"] == state.end_tension


@pytest.mark.parametrize(("path", "limit"), [(STRAIGHT, 1e-3), (PATH, 1e-2)], ids=["straight", "kinked"])
def test_against_a_rod_integrated_section_by_section(path, limit):
    """Tip and tension of the integrated rod at the same length, and what friction adds to the tension.

    A path that turns or ends inside an element is first order in its size: 7.8e-3 with 32, 3.9e-3 with 64
    elements, without friction too.
    """
    (before,) = Model(scene([{"length": L, "path": path}])).constraints.tendons
    wanted, tensions = before.l_0 - 2e-4 * L, []
    for friction in (0.4, 0.0):
        cable = {"length": wanted, "friction": friction, "path": path}
        solution = ancf.solve(scene([cable], {"element": "3343", "elements": 32}))
        tip, error, tension = tendon_rod_of_length(L, RADIUS, YOUNG, 0.3, wanted, path, friction)
        assert error < 1e-7 * L
        assert np.linalg.norm(solution.tip().position - tip) <= 1e-4 * L
        assert solution.tendons[0].tension == pytest.approx(tension, rel=limit)
        tensions.append((solution.tendons[0].tension, tension))
    (found, exact), (found_0, exact_0) = tensions
    assert exact / exact_0 > 1.005  # friction that is to be seen
    assert found / found_0 == pytest.approx(exact / exact_0, rel=1e-4)


@settings(deadline=None, max_examples=15)
@given(st.floats(0.05, 2.0), st.floats(-2.0, 2.0), st.floats(0.01, 2.0))
@example(1.0, 0.0, 0.3)
def test_tension_to_length_and_back(share, load, friction):
    """The length that a tension makes asks for that tension, to 1e-9, under another load too."""
    tables = {"force": [{"value": [0.0, 0.3 * load * EI / L**2, load * EI / L**2]}]}
    tension, rest = share * EI / (L * D), {"path": PATH, "friction": friction}
    pulled = ancf.solve(scene([{"tension": tension, **rest}], **tables))
    held = ancf.solve(scene([{"length": pulled.tendon_lengths()[0], **rest}], **tables))
    assert held.status == "converged"
    assert held.tendons[0].tension == pytest.approx(tension, rel=1e-9)
    assert held.tendons[0].end_tension == pytest.approx(pulled.tendons[0].end_tension, rel=1e-9)
    np.testing.assert_allclose(held.q[: pulled.q.size], pulled.q, rtol=0, atol=1e-10)


@pytest.mark.parametrize("m", [0.7, -0.7])
@pytest.mark.parametrize("element", ["3333", "3363"])
def test_tangent_and_rate_are_the_derivatives(element, m):
    """dg/dq and dg/dl of the whole residual at a random state, by central differences; not symmetric."""
    curved = {"element": element, "curvature": [0.3, 1, 0]}
    rubbing = {"length": 0.97 * L, "friction": 0.8, "path": PATH}
    model = Model(scene([rubbing, tendon(2.0, length=0.99 * L)], curved))
    assert [type(one) for one in model.constraints.tendons] == [RubbingTendonLength, TendonLength]
    assert not model.conservative
    system = model.system
    assert isinstance(system, CoupledSystem)
    rng = np.random.default_rng(5)
    q = model.q0 + 0.02 * rng.uniform(-1, 1, model.n) * model.unit
    q[model.motions :] = np.array([m, 0.4]) * model.unit[model.motions :]
    way = rng.uniform(-1, 1, model.n) * model.unit
    model.constraints.take_sides(q)
    forces, flat = model.residual_and_tangent(q, 0.6)
    step = 1e-6
    ends = [model.residual(q + s * step * way, 0.6).at(0.6) for s in (1, -1)]
    change = (ends[0] - ends[1]) / (2 * step) / model.force_unit
    K = system.unsupported(flat)
    np.testing.assert_allclose(K @ way / model.force_unit, change, rtol=0, atol=1e-7 * np.abs(change).max())
    if m > 0.0:
        assert abs(K - K.T).max() > 1e-6 * abs(K).max()  # the axis is stiff
    ends = [model.residual(q, 0.6 + s).at(0.6 + s) for s in (0.1, -0.1)]
    np.testing.assert_allclose(forces.Q_ext, -(ends[0] - ends[1]) / 0.2, rtol=0, atol=1e-10)


def test_newton_stays_quadratic():
    cable = [{"length": 0.999 * L, "path": PATH, "friction": 0.5}]
    solution = ancf.solve(scene(cable, force=[{"value": [0, 0, EI / L**2]}]))
    steps = [entry.step for entry in solution.history]
    assert solution.status == "converged"
    assert len(steps) <= 8 and steps[-1] <= 10 * steps[-2] ** 1.7


def test_a_slack_tendon_does_not_rub():
    tables = {"force": [{"value": [0, 0.5 * EI / L**2, 0]}]}
    solution = ancf.solve(scene([tendon(np.pi, length=1.1 * L, friction=0.5)], **tables))
    without = ancf.solve(scene([], **tables))
    np.testing.assert_allclose(solution.q[:-1], without.q, rtol=0, atol=1e-12)
    (state,) = solution.tendons
    assert state.tension == state.end_tension == 0.0
    assert state.length + state.slack == pytest.approx(1.1 * L, abs=1e-10 * L)


@settings(deadline=None, max_examples=15)
@given(
    st.lists(st.floats(-0.006, 0.006), min_size=2, max_size=4),
    st.lists(st.floats(-2, 2), min_size=3, max_size=3),
    st.floats(0.01, 1.0),
)
@example([0.003, -0.004], [0.0, 0.0, 0.0], 0.3)
@example([0.002, 0.001, -0.001], [0.0, 1.0, 0.0], 0.3)
def test_any_lengths_meet_the_conditions(changes, load, friction):
    """l <= wanted, T >= 0, and one of them with equality, for tendons round the axis."""
    angles = 2 * np.pi * np.arange(len(changes)) / len(changes)
    cables = [tendon(a, length=L - c, friction=friction) for a, c in zip(angles, changes, strict=True)]
    forces = [{"value": (np.array(load) * EI / L**2).tolist()}]
    solution = ancf.solve(scene(cables, force=forces))
    assert solution.status == "converged", solution.message
    for one in solution.tendons:
        assert one.tension >= one.end_tension >= 0.0 and one.slack >= 0.0
        assert one.tension == 0.0 or one.slack == 0.0
        assert one.length + one.slack == pytest.approx(one.tendon.length, abs=1e-10 * L)


def test_less_and_less_friction_is_none():
    (one,) = Model(scene([tendon(length=0.99 * L, friction=0.0)])).constraints.tendons
    assert type(one) is TendonLength
    tips = [
        ancf.solve(scene([{"length": 0.999 * L, "path": PATH, "friction": mu}])).tip().position
        for mu in (0.0, 1e-7, 2e-7)
    ]
    assert np.linalg.norm(tips[1] - tips[0]) < 1e-6 * L
    np.testing.assert_allclose(tips[2] - tips[0], 2 * (tips[1] - tips[0]), rtol=1e-3, atol=1e-12 * L)


def test_walked_swept_and_varied():
    """Load steps and rows come to the same shape; the sensitivity by the length is that of differences."""
    lengths = L - np.array([0.0005, 0.002])
    cables = [{"length": L, "path": STRAIGHT, "friction": 0.5}, tendon(2.0, tension=0.2 * EI / (L * D))]

    def alone(length, **solver):
        return ancf.solve(scene([cables[0] | {"length": float(length)}, cables[1]], solver=solver))

    found = [alone(length) for length in lengths]
    batch = ancf.solve_batch(scene(cables), lengths=lengths)
    assert (batch.status == "converged").all()
    tips = [one.tip().position for one in found]
    np.testing.assert_allclose(batch.poses[:, :, 0], tips, rtol=0, atol=1e-9 * L)
    np.testing.assert_allclose(alone(lengths[1], predictor="none").q, found[1].q, rtol=0, atol=1e-8)
    step = 1e-6
    ends = [alone(lengths[1] + s * step).tip().position for s in (1, -1)]
    exact = (ends[0] - ends[1]) / (2 * step)
    slope = found[1].sensitivity("tendon_length")[:3]
    np.testing.assert_allclose(slope, exact, rtol=0, atol=1e-5 * np.abs(exact).max())


def test_forces_balance_and_a_state_resumes(tmp_path):
    solution = ancf.solve(scene([{"length": 0.998 * L, "path": PATH, "friction": 0.5}]))
    force, moment = solution.reaction()
    np.testing.assert_allclose(force, 0.0, atol=1e-9 * EI / L**2)
    np.testing.assert_allclose(moment, 0.0, atol=1e-9 * EI / L)
    solution.save(tmp_path / "state.npz")
    again = ancf.resume(solution.scene, tmp_path / "state.npz")
    assert again.iterations <= 2
    np.testing.assert_allclose(again.q, solution.q, rtol=0, atol=1e-12)


def test_a_cable_that_is_held_is_warned_about():
    """A force bends the rod away from a cable that is not taken in: it pulls, and slides the other way."""
    away, towards = ([{"value": [0.0, s * 0.5 * EI / L**2, 0.0]}] for s in (-1, 1))
    held = ancf.solve(scene([tendon(length=L, friction=0.3)], force=away))
    assert held.tendons[0].tension > 0.0
    assert any("held or let out" in text for text in held.warnings)
    for one, force in (
        (tendon(length=L, friction=0.3), towards),  # slack
        (tendon(length=0.999 * L, friction=0.3), away),  # taken in
        (tendon(length=L), away),
    ):
        assert not any("let out" in text for text in ancf.solve(scene([one], force=force)).warnings)


@pytest.mark.parametrize(
    ("friction", "hint"), [(-0.1, ">= 0"), (float("inf"), "friction"), ("2 N", "friction")]
)
def test_bad_friction_is_refused(friction, hint):
    with pytest.raises(ancf.SceneError) as refused:
        scene([tendon(length=0.4, friction=friction)])
    assert hint in str(refused.value) and "tendon[0]" in str(refused.value) and "try:" in str(refused.value)
