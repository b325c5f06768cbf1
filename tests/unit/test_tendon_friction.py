"""Tendons with friction: capstan law, exact derivative, closed form, what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import ancf
from ancf.effects.tendon import PulledTendon
from ancf.effects.tendon_friction import RubbingTendon
from ancf.model import Model
from reference.actuation import frictional_arc
from tests.effect_checks import blocks, check_derivatives, check_rigid_motion

L, RADIUS, YOUNG = 0.5, 2.5e-3, 1e6
EI, EA = YOUNG * np.pi * RADIUS**4 / 4, YOUNG * np.pi * RADIUS**2
D = 0.8 * RADIUS
TENSION = 1e-4 * EA
STRAIGHT = [[0.0, D, 0.0], [1.0, D, 0.0]]
PATH = [[0.05, D, 0.0], [0.33, 0.0, 0.6 * D], [0.5, -0.5 * D, 0.0], [0.9, -0.5 * D, 0.4 * D]]


def scene(friction, path=STRAIGHT, rod=None, tension=TENSION, **tables):
    data = {
        "length": L, "elements": 8, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3, "density": 1000.0},
    } | (rod or {})  # fmt: skip
    tendon = {"tension": tension, "path": path, "friction": friction}
    return ancf.scene_from_dict({"rod": [data], "tendon": [tendon], **tables})


@pytest.mark.parametrize("friction", [0.1, 0.5, 2.0])
@pytest.mark.parametrize("element", ["3333", "3343"])
def test_a_straight_tendon_bends_less_and_less(element, friction):
    """kappa = kappa_0/(1 + mu kappa_0 s), at L/R = 200 within 1e-3 L, but for the thrust T/(E A) = 1e-4."""
    solution = ancf.solve(scene(friction, rod={"element": element}))
    assert solution.status == "converged" and solution.iterations <= 5
    kappa = TENSION * D / EI
    tip = solution.tip().position
    assert np.linalg.norm(tip - frictional_arc(L, kappa, friction)) <= 1.1e-4 * L
    # Sideways the thrust hardly counts.
    assert tip[1] == pytest.approx(frictional_arc(L, kappa, friction)[1], rel=2e-4)
    (state,) = solution.tendons
    assert state.end_tension == pytest.approx(TENSION / (1 + friction * kappa * L), rel=1e-4)
    entry = solution.as_dict()["tendons"][0]
    assert entry["tension"] == TENSION and entry["end_tension"] == state.end_tension


def test_the_moment_falls_with_the_turning():
    """m = d T exp(-mu theta), theta the turn of the section (statics of the cut)."""
    solution = ancf.solve(scene(1.0, tension=20 * TENSION, rod={"elements": 32}))
    forces = solution.section_forces()
    for at, moment in zip(forces.at, forces.moment, strict=True):
        if at < 0.05:  # where the clamp keeps the section from widening
            continue
        turn = np.arctan2(*solution.pose(None, at).rotation[[1, 0], 0])
        assert moment[2] == pytest.approx(20 * TENSION * D * np.exp(-turn), rel=3e-3)


@pytest.mark.parametrize("element", ["3333", "3243", "3363"])
def test_the_tangent_is_the_derivative(element):
    """dQ/de by central differences at a random state; no potential, and not symmetric."""
    model = Model(scene(0.7, PATH, {"element": element, "curvature": [0.3, 1.0, -0.5]}))
    check_derivatives(model, strain=0.05, step=1e-6)
    assert not model.conservative
    (effect,) = model.effects
    assert isinstance(effect, RubbingTendon) and effect.coupled
    _, K = effect.force_and_tangent(blocks(model, effect))
    assert np.abs(K - np.swapaxes(K, 1, 2)).max() > 1e-3 * np.abs(K).max()


@settings(deadline=None)
@given(st.lists(st.floats(-2, 2), min_size=6, max_size=6))
def test_it_turns_with_the_rod(numbers):
    """A rigid motion changes neither the tension left nor, but for the turn, the forces; they balance."""
    model = Model(scene(0.7, PATH, {"curvature": [0.3, 1.0, -0.5]}))
    fine = 1e-12 * TENSION
    check_rigid_motion(model, RubbingTendon.end_share, numbers, 1e-12, fine, fine, arm=L)


def test_kinks_of_the_path_take_their_share():
    """On a straight rod the path turns at its points alone: angles between the pieces (trigonometry)."""
    model = Model(scene(0.7, PATH, {"elements": 5}))
    (effect,) = model.effects
    ways = np.diff(np.array(PATH) * [L, 1, 1], axis=0)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    angles = np.arccos(np.sum(ways[1:] * ways[:-1], axis=1))
    path = effect.capstan
    shares = path.shares(model.q0[path.dofs].reshape(len(path.dofs), -1, 3))
    assert shares[0] == 1.0 and np.all(np.diff(shares) <= 1e-12)
    assert effect.end_share(blocks(model, effect)) == pytest.approx(np.exp(-0.7 * angles.sum()), rel=1e-10)
    order = np.argsort(-shares)
    np.testing.assert_array_equal(np.sort(order), np.arange(len(shares)))


def test_no_friction_is_the_tendon_without():
    """The default, and the limit of small friction."""
    model = Model(scene(0.0, PATH))
    assert type(model.effects[0]) is PulledTendon
    tips = [ancf.solve(scene(mu, PATH)).tip().position for mu in (0.0, 1e-7, 2e-7)]
    assert np.linalg.norm(tips[1] - tips[0]) < 1e-6 * L
    np.testing.assert_allclose(tips[2] - tips[0], 2 * (tips[1] - tips[0]), rtol=1e-3, atol=1e-12 * L)


def test_sweeps_derivatives_and_stability():
    """Rows are what `solve` finds; the sensitivity that of differences; of stability little is known."""
    tables = {"force": [{"value": [0, 0, 0.5 * EI / L**2]}]}
    rows = np.array([0.5, 1.0, 8.0]) * TENSION
    batch = ancf.solve_batch(scene(0.5, PATH, **tables), tensions=rows)
    alone = [ancf.solve(scene(0.5, PATH, tension=float(row), **tables)) for row in rows]
    tips = np.array([one.tip().position for one in alone])
    np.testing.assert_allclose(batch.poses[:, :, 0], tips, rtol=0, atol=1e-9 * L)
    step = 1e-4 * TENSION
    ends = [
        ancf.solve(scene(0.5, PATH, tension=float(rows[2] + s * step), **tables)).tip().position
        for s in (1, -1)
    ]
    found = batch.sensitivity("tension")[2][:3] * TENSION
    np.testing.assert_allclose(found, (ends[0] - ends[1]) / 2e-4, rtol=0, atol=1e-6 * L)
    assert alone[0].stable is None
    walked = ancf.solve(scene(0.5, PATH, tension=float(rows[2]), solver={"predictor": "none"}, **tables))
    np.testing.assert_allclose(walked.tip().position, tips[2], rtol=0, atol=1e-8 * L)


def test_forces_balance():
    solution = ancf.solve(scene(0.5, PATH, tension=8 * TENSION))
    force, moment = solution.reaction()
    np.testing.assert_allclose(force, 0.0, atol=1e-9 * EI / L**2)
    np.testing.assert_allclose(moment, 0.0, atol=1e-9 * EI / L)


@pytest.mark.parametrize(
    ("keys", "hint"),
    [
        ({"friction": -0.1}, ">= 0"),
        ({"friction": float("inf")}, "friction"),
        ({"friction": "2 N"}, "friction"),
        ({"frction": 0.1}, "friction"),
    ],
)
def test_bad_friction_is_refused(keys, hint):
    tendon = {"path": STRAIGHT, **({} if "length" in keys else {"tension": 1.0}), **keys}
    rod = {
        "length": L,
        "elements": 4,
        "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3},
    }
    with pytest.raises(ancf.SceneError) as refused:
        ancf.scene_from_dict({"rod": [rod], "tendon": [tendon]})
    assert hint in str(refused.value) and "tendon[0]" in str(refused.value)


@pytest.mark.parametrize("side", [1, -1])
def test_a_kink_against_the_bend_is_not_cut_short(side):
    """In a plane: the turns of the smooth runs and of the kinks add up, whatever way they go."""
    bent = ancf.solve(scene(0.0, tension=0.0, moment=[{"value": [0.0, 0.0, EI / L]}]))
    kinked = [[0.0, side * D, 0.0], [0.375, -side * D, 0.0], [0.7, side * D, 0.0], [1.0, side * D, 0.0]]
    (effect,) = Model(scene(1.0, kinked)).effects
    path = effect.capstan
    e = bent.q[path.dofs].reshape(len(path.dofs), -1, 3)
    first = np.flatnonzero(path.starts)
    last = np.append(first[1:], len(path.a)) - 1
    c = [
        path.ends[piece, k] @ e[piece]
        for pair in zip(first, last, strict=True)
        for k, piece in enumerate(pair)
    ]
    turns = np.diff(np.unwrap(np.arctan2([v[1] for v in c], [v[0] for v in c])))
    assert (turns[::2] > 0.2).all() and {*np.sign(turns[1::2])} == {1.0, -1.0}
    assert np.abs(turns[1::2]).min() > 5e-3  # 2 D in a third of the length
    assert effect.end_share(bent.q[effect.dofs]) == pytest.approx(np.exp(-np.abs(turns).sum()), rel=1e-9)
