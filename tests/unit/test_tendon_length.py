"""Tendons of controlled length: closed forms, exact derivatives, taut or slack, what is refused."""

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

import ancf
from ancf.coupled_system import CoupledSystem
from ancf.model import Model
from ancf.newton import NewtonRun
from ancf.predictor import load_start
from tests.tendon_scenes import EA, EI, RADIUS, YOUNG, D, L, scene, tendon

PATH = [[0.0, D, 0.0], [0.33, 0.0, 0.6 * D], [0.9, -0.5 * D, 0.4 * D]]


def ring(lengths):
    """Tendons round the axis, L shorter by so much each."""
    angles = 2 * np.pi * np.arange(len(lengths)) / len(lengths)
    return [tendon(angle, length=L - change) for angle, change in zip(angles, lengths, strict=True)]


def check_conditions(solution):
    """l <= wanted, T >= 0, and one of them with equality; lengths to 1e-10 against the shape itself."""
    for one in solution.tendons:
        wanted = one.tendon.length
        assert one.tension >= 0.0 and one.slack >= 0.0
        assert one.tension == 0.0 or one.slack == 0.0
        assert one.length + one.slack == pytest.approx(wanted, abs=1e-10 * L)


@pytest.mark.parametrize("element", ["3333", "3343", "3363"])
def test_a_straight_tendon_of_given_length_bends_to_an_arc(element):
    """Shorter by L (T/E A + T d^2/E I), thin rod: tension, and the arc of the shortened axis to 1e-3 L."""
    tension = 1e-4 * EA
    kappa = tension * D / EI
    stretch = 1 - tension / EA
    wanted = L * (stretch - kappa * D)
    solution = ancf.solve(scene([tendon(length=wanted)], {"element": element, "elements": 12}))
    assert solution.status == "converged" and solution.stable and solution.steps == 1
    (state,) = solution.tendons
    assert state.length == pytest.approx(wanted, abs=1e-10 * L)
    # Measured 2.5e-4 (3333, whose clamp stops the section from contracting: 1/8 of the first element).
    assert state.tension == pytest.approx(tension, rel=1e-2)
    angle = kappa * L
    exact = stretch / kappa * np.array([np.sin(angle), 1 - np.cos(angle), 0.0])
    assert np.linalg.norm(solution.tip().position - exact) <= 1e-3 * L


@settings(deadline=None, max_examples=15)
@given(st.floats(0.05, 2.0), st.floats(-2.0, 2.0))
@example(1.0, 0.0)
def test_tension_to_length_and_back(share, load):
    """The length that a tension makes asks for that tension, under another load too."""
    tables = {"force": [{"value": [0.0, 0.3 * load * EI / L**2, load * EI / L**2]}]}
    tension = share * EI / (L * D)
    pulled = ancf.solve(scene([{"tension": tension, "path": PATH}], **tables))
    held = ancf.solve(scene([{"length": pulled.tendon_lengths()[0], "path": PATH}], **tables))
    assert held.status == "converged"
    assert held.tendons[0].tension == pytest.approx(tension, rel=1e-6)
    np.testing.assert_allclose(held.q[: pulled.q.size], pulled.q, rtol=0, atol=1e-7)
    assert held.stable == pulled.stable


@pytest.mark.parametrize("m", [0.7, -0.7])
def test_tangent_and_rate_are_the_derivatives(m):
    """dg/dq and dg/dl of the whole residual at a random state, by central differences."""
    model = Model(
        scene([{"length": 0.97 * L, "path": PATH}, tendon(2.0, length=0.99 * L)], {"curvature": [0.3, 1, 0]})
    )
    system = model.system
    assert isinstance(system, CoupledSystem)
    rng = np.random.default_rng(5)
    q = model.q0 + 0.02 * rng.uniform(-1, 1, model.n) * model.unit
    q[model.motions :] = np.array([m, 0.4]) * model.unit[model.motions :]
    way = rng.uniform(-1, 1, model.n) * model.unit
    taut = model.constraints.tendons[0].is_taut(m)
    assert taut == (m > 0.0)
    model.constraints.take_sides(q)
    forces, flat = model.residual_and_tangent(q, 0.6)
    step = 1e-6
    ends = [model.residual(q + s * step * way, 0.6).at(0.6) for s in (1, -1)]
    change = (ends[0] - ends[1]) / (2 * step) / model.force_unit
    found = system.unsupported(flat) @ way / model.force_unit
    np.testing.assert_allclose(found, change, rtol=0, atol=1e-7 * np.abs(change).max())
    K = system.unsupported(flat).toarray()
    if not taut:  # it acts on nothing
        assert not K[: model.motions, model.motions].any()
        K[model.motions, : model.motions] = 0.0
    assert np.abs(K - K.T).max() <= 1e-12 * np.abs(K).max()
    ends = [model.residual(q, 0.6 + s).at(0.6 + s) for s in (0.1, -0.1)]
    np.testing.assert_allclose(forces.Q_ext, -(ends[0] - ends[1]) / 0.2, rtol=0, atol=1e-10)


def test_newton_stays_quadratic():
    solution = ancf.solve(scene(ring([0.004, 0.002, -0.004])))
    steps = [entry.step for entry in solution.history]
    assert len(steps) <= 6 and steps[-1] <= 10 * steps[-2] ** 1.7


def test_a_longer_tendon_is_slack_and_does_nothing():
    tables = {"force": [{"value": [0, 0.5 * EI / L**2, 0]}]}
    solution = ancf.solve(scene([tendon(np.pi, length=1.1 * L)], **tables))
    without = ancf.solve(scene([], **tables))
    np.testing.assert_allclose(solution.q[:-1], without.q, rtol=0, atol=1e-12)
    assert solution.stable
    (state,) = solution.tendons
    assert state.tension == 0.0 and state.length + state.slack == pytest.approx(1.1 * L, abs=1e-10 * L)
    entry = solution.as_dict()["tendons"][0]
    assert entry == {"rod": "rod", "tension": 0.0, "length": state.length, "slack": state.slack}
    assert solution.effects["tendon"]["calls"] > 0 and "joint" not in solution.effects


@pytest.mark.parametrize(
    ("changes", "taut"),
    [
        ((0.003, -0.004), (True, False)),  # the antagonist has more cable than the bend takes
        ((0.003, 0.0), (True, True)),  # it is held where it was, and is stretched
        ((0.002, 0.001), (True, True)),
        ((0.0, 0.0), (False, False)),
        ((0.003, -0.001, -0.001), (True, False, False)),
        ((0.003, 0.002, -0.001), (True, True, False)),
        ((0.003, 0.002, -0.01), (True, True, False)),
    ],
)
def test_antagonists(changes, taut):
    """Who pulls; the same from the guess of linear theory, in load steps, and from the others' shapes."""
    solution = ancf.solve(scene(ring(changes)))
    assert solution.status == "converged" and solution.iterations <= 12
    check_conditions(solution)
    if any(changes):
        assert tuple(one.tension > 0.0 for one in solution.tendons) == taut
    walked = ancf.solve(scene(ring(changes), solver={"predictor": "none"}))
    np.testing.assert_allclose(walked.q, solution.q, rtol=0, atol=1e-8)
    opposite = solution.q.copy()
    opposite[solution.model.motions :] *= -1.0  # those that pull begin as slack, and the reverse
    again = ancf.solve(solution.scene, start=opposite)
    np.testing.assert_allclose(again.q, solution.q, rtol=0, atol=1e-8)


@settings(deadline=None, max_examples=25)
@given(
    st.lists(st.floats(-0.006, 0.006), min_size=2, max_size=5),
    st.lists(st.floats(-2, 2), min_size=3, max_size=3),
)
@example([0.001, 0.001, 0.001, 0.001], [0.0, 0.0, 0.0])
@example([0.005859375, 0.0, 0.0, 0.0, 0.001953125], [0.0, 0.0, 1.0])
@example([0.004, 0.004, -0.004, -0.004, 0.0], [0.0, 0.0, 0.0])
def test_any_lengths_meet_the_conditions(changes, load):
    """Random lengths and loads: nothing pushes, nothing is stretched, and it does not go back and forth."""
    forces = [{"value": (np.array(load) * EI / L**2).tolist()}]
    solution = ancf.solve(scene(ring(changes), force=forces))
    assert solution.status == "converged", solution.message
    check_conditions(solution)


def test_two_tendons_on_one_path():
    """The shorter one pulls; with both as conditions the tangent would be singular."""
    solution = ancf.solve(scene([tendon(length=L - 0.001), tendon(length=L - 0.002)]))
    assert solution.status == "converged"
    check_conditions(solution)
    assert [one.tension > 0 for one in solution.tendons] == [False, True]


def test_beside_a_tendon_of_given_tension():
    """A pull of 0.5 E I/(L d) on one side, no cable let out on the other: that one is stretched and pulls."""
    pull = 0.5 * EI / (L * D)
    solution = ancf.solve(scene([tendon(tension=pull), tendon(np.pi, length=L)]))
    first, second = solution.tendons
    # Bending is taken away: one pull is all thrust, L T/E A + (shorter axis) = 0 on the other side.
    # kappa d = (T1 + T2)/E A and kappa = (T1 - T2) d/E I give T2/T1 = (d^2 E A - E I)/(d^2 E A + E I).
    ratio = (D**2 * EA - EI) / (D**2 * EA + EI)
    assert first.tension == pull and first.slack is None
    assert second.tension / pull == pytest.approx(ratio, rel=5e-3)


def test_negative_eigenvalues_are_those_across_the_conditions():
    """Counted by the bordered matrix; and by a dense basis of the motions that taut tendons leave."""
    model = Model(scene(ring([0.004, -0.003])))
    solution = ancf.solve(model.scene)
    loaded = solution.q.copy()
    for push in (0.0, -40.0):  # a thrust makes it unstable
        tables = {"force": [{"value": [push * EI / L**2, 0, 0]}]}
        model = Model(scene(ring([0.004, -0.003]), **tables))
        _, flat = model.residual_and_tangent(loaded, 1.0)
        K = model.system.unsupported(flat).toarray()
        B = model.boundary_matrix().toarray()
        free = B[: model.motions, : B.shape[1] - 2]
        C = K[model.motions, : model.motions] @ free  # of the first, which is taut
        basis = np.linalg.svd(C[None])[2][1:].T
        dense = basis.T @ free.T @ K[: model.motions, : model.motions] @ free @ basis
        count = int(np.count_nonzero(np.linalg.eigvalsh(dense) < 0))
        assert model.system.negative_eigenvalues(flat) == count
    compressed = ancf.solve(scene([tendon(length=L + 0.001)], force=[{"value": [-10 * EI / L**2, 0, 0]}]))
    assert compressed.status == "converged" and compressed.stable is False  # Euler: pi^2/4


def test_sensitivity():
    """By length and by a number of the rod, against differences of solves; nothing where it is slack."""
    changes = np.array([0.004, 0.001, -0.004])
    solution = ancf.solve(scene(ring(changes)))
    step = 1e-6
    for index in range(3):
        ends = [ancf.solve(scene(ring(changes - s * step * np.eye(3)[index]))) for s in (1, -1)]
        exact = (ends[0].tip().position - ends[1].tip().position) / (2 * step)
        found = solution.sensitivity("tendon_length", index=index)
        assert found.shape == (12,)
        np.testing.assert_allclose(found[:3], exact, rtol=0, atol=1e-5 * np.abs(exact).max() + 1e-9)
    assert np.all(found == 0.0)
    tables = {"force": [{"value": [0, 0, EI / L**2]}]}
    softer, stiffer = (
        ancf.solve(scene(ring(changes), {"material": {"young_modulus": E, "poisson_ratio": 0.3}}, **tables))
        for E in (0.999 * YOUNG, 1.001 * YOUNG)
    )
    exact = (stiffer.tip().position - softer.tip().position) / (0.002 * YOUNG)
    found = ancf.solve(scene(ring(changes), **tables)).sensitivity("young_modulus")[:3]
    np.testing.assert_allclose(found * YOUNG, exact * YOUNG, rtol=0, atol=1e-5 * L)


def test_sweeps():
    """A batch of lengths is what `solve` finds."""
    tables = [*ring([0.0, 0.0]), tendon(1.0, tension=0.1 * EI / (L * D))]
    rows = L - np.array([[0.001, -0.004], [0.003, 0.0], [0.0, 0.002]])
    batch = ancf.solve_batch(scene(tables), lengths=rows)
    assert (batch.status == "converged").all() and batch.engine == "solve"
    for row, pose in zip(rows, batch.poses, strict=True):
        for table, length in zip(tables, row, strict=False):
            table["length"] = float(length)
        alone = ancf.solve(scene(tables))
        np.testing.assert_allclose(pose[:, 0], alone.tip().position, rtol=0, atol=1e-9 * L)
    first = ancf.solve_batch(scene(tables), lengths=rows[:, 0], tensions=[0.0] * 3)
    assert len(first) == 3 and first.sensitivity("tendon_length").shape == (3, 12)


def test_saved_resumed_and_refined(tmp_path):
    solution = ancf.solve(scene(ring([0.003, 0.001, -0.004])))
    solution.save(tmp_path / "state.npz")
    again = ancf.resume(solution.scene, tmp_path / "state.npz")
    assert again.iterations <= 2
    np.testing.assert_allclose(again.q, solution.q, rtol=0, atol=1e-12)
    fewer = scene(ring([0.003, 0.001, -0.004])[:2])
    with pytest.raises(ancf.InputError):
        ancf.resume(fewer, tmp_path / "state.npz")
    data = {"length": L, "section": {"shape": "circle", "radius": RADIUS}}
    data["material"] = {"young_modulus": YOUNG, "poisson_ratio": 0.3}
    wanted = {"rod": [data], "tendon": ring([0.003, 0.001, -0.004]), "solver": {"accuracy": 1e-3}}
    accurate = ancf.solve(ancf.scene_from_dict(wanted))
    assert accurate.status == "converged" and accurate.accuracy.met
    np.testing.assert_allclose(accurate.tip().position, solution.tip().position, rtol=0, atol=2e-3 * L)


def test_along_the_arc():
    """Path following comes to the same equilibrium."""
    plain = ancf.solve(scene(ring([0.003, -0.001])))
    followed = ancf.solve(scene(ring([0.003, -0.001]), solver={"method": "arclength"}))
    assert followed.status == "converged"
    np.testing.assert_allclose(followed.q, plain.q, rtol=0, atol=1e-7)


def test_forces_balance():
    """A tendon inside the rod exerts nothing on the support."""
    solution = ancf.solve(scene([{"length": 0.98 * L, "path": PATH}]))
    force, moment = solution.reaction()
    np.testing.assert_allclose(force, 0.0, atol=1e-9 * EI / L**2)
    np.testing.assert_allclose(moment, 0.0, atol=1e-9 * EI / L)


def test_the_start_is_near():
    model = Model(scene([tendon(0.3, length=L - 0.5 * D)]))  # half a radian
    start, solution = load_start(model), ancf.solve(model.scene)
    assert np.linalg.norm((solution.q - start)[:-1] / model.unit[:-1], np.inf) < 0.05
    assert start[-1] == pytest.approx(solution.q[-1], rel=0.05)


@pytest.mark.parametrize(
    ("keys", "hint"),
    [
        ({}, "neither tension nor length"),
        ({"length": 0.4, "tension": 1.0}, "both a tension and a length"),
        ({"length": 0.0}, "> 0"),
        ({"length": -0.4}, "> 0"),
        ({"length": float("nan")}, "length"),
        ({"length": "3 N"}, "length"),
        ({"lenght": 0.4}, "length"),
    ],
)
def test_bad_lengths_are_refused(keys, hint):
    with pytest.raises(ancf.SceneError) as refused:
        scene([tendon(**keys)])
    message = str(refused.value)
    assert hint in message and "tendon[0]" in message and "try:" in message


def test_what_cannot_be_asked_for():
    with pytest.raises(ancf.SceneError, match="no finite-difference tangent"):
        scene(ring([0.0]), solver={"tangent": "finite-difference"})
    solution = ancf.solve(scene([tendon(length=L - 0.001), tendon(1.0, tension=0.1)]))
    for parameter, index in (("tension", 0), ("tendon_length", 1), ("tendon_length", 2)):
        with pytest.raises(ancf.InputError):
            solution.sensitivity(parameter, index=index)
    for rows, hint in (({"lengths": [-0.1]}, "> 0"), ({"lengths": [[0.1, 0.2]]}, "wrong shape")):
        with pytest.raises(ancf.InputError, match=hint):
            ancf.solve_batch(solution.scene, **rows)
    with pytest.raises(ancf.InputError, match="no tendon with a length"):
        ancf.solve_batch(scene([tendon(tension=0.1)]), lengths=[0.4])


def test_a_length_out_of_reach_has_no_equilibrium():
    """Half of the rod's length cannot be had by bending within the section: a status with its reason."""
    solution = ancf.solve(scene([tendon(length=0.05 * L)], solver={"max_steps": 20}))
    assert solution.status != "converged" and solution.reason
    assert solution.load_factor < 1.0


def test_sides_that_loads_change_are_chosen_at_once():
    """A force bends the rod over: linear theory without it names the wrong tendon, about it the right one."""
    forces = [{"value": [0.0, 1.5 * EI / L**2, 0.0]}]
    model = Model(scene(ring([0.0005, -0.0006]), force=forces))
    run = NewtonRun(model, load_start(model), 1.0)
    assert model.constraints.sides == (True, False)
    while not run.done:
        run.advance(*model.residual_and_tangent(run.q, 1.0, run.q_previous))
    assert run.result.converged and run.sides_tried == 2
    assert model.constraints.sides == (False, True)


def test_a_slack_tendon_does_not_hold_a_column():
    """2 % above Euler's load, pi^2 E I/(4 L^2), a round column has two negative eigenvalues."""
    forces = [{"value": [-1.02 * np.pi**2 / 4 * EI / L**2, 0, 0]}]
    solution = ancf.solve(scene([tendon(length=1.1 * L)], force=forces))
    _, flat = solution.model.residual_and_tangent(solution.q, 1.0)
    assert solution.model.system.negative_eigenvalues(flat) == 2
