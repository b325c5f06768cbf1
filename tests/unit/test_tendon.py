"""Tendons: closed forms, the exact derivative, balance, length, and what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import ancf
from ancf.effects.tendon import PulledTendon
from ancf.model import Model
from ancf.predictor import load_start
from tests.effect_checks import check_derivatives, check_rigid_motion

L, RADIUS, YOUNG = 0.4, 0.01, 1e6
EI, EA = YOUNG * np.pi * RADIUS**4 / 4, YOUNG * np.pi * RADIUS**2
NO_POISSON = {"young_modulus": YOUNG, "poisson_ratio": 0.0}  # no clamp that keeps the section from widening
TENSION = 0.5 * EI / (L * 0.005)
PATH = [[0.0, 0.005, 0.0], [0.33, 0.0, 0.004], [0.9, -0.003, 0.002]]


def scene(rod=None, **tables):
    data = {
        "length": L, "elements": 6, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3, "density": 1000.0},
    } | (rod or {})  # fmt: skip
    return ancf.scene_from_dict({"rod": [data], **tables})


def tendon(**keys):
    return {"tendon": [{"tension": TENSION, "path": PATH, **keys}]}


def straight(tension, offset, radius=RADIUS):
    return {"tendon": [{"tension": tension, "path": [[0.0, *offset], [1.0, *offset]]}]}


@pytest.mark.parametrize("element", ["3333", "3243", "3363"])
@pytest.mark.parametrize("share", [1e-4, 2e-5])
def test_a_straight_tendon_bends_to_an_arc(element, share):
    """kappa = T d/(E I) at L/R = 200 and T/(E A) <= 1e-4: the tip within 1e-3 L (thin rod, closed form).

    The axis is shorter by T/(E A), which is all of the difference for elements that do not lock.
    """
    radius, length = 2.5e-3, 0.5
    tension, d = share * YOUNG * np.pi * radius**2, 0.8 * radius
    kappa = tension * d / (YOUNG * np.pi * radius**4 / 4)
    thin = {
        "length": length,
        "section": {"shape": "circle", "radius": radius},
        "element": element,
        "elements": 12,
    }
    for y, z, bent in ((d, 0.0, [0, 1, 0]), (0.0, -d, [0, 0, -1])):
        solution = ancf.solve(scene(thin, **straight(tension, (y, z))))
        assert solution.status == "converged" and solution.stable
        angle = kappa * length
        exact = np.array([np.sin(angle), 0, 0]) / kappa + (1 - np.cos(angle)) / kappa * np.array(bent)
        limit = 1e-3 if element == "3243" else 1.1 * share
        assert np.linalg.norm(solution.tip().position - exact) <= limit * length


def test_a_centred_tendon_only_shortens():
    """Uniaxial Saint Venant-Kirchhoff under the thrust T: E A (s^2 - 1) s/2 = -T (theory of the law)."""
    tension = 0.02 * EA
    solution = ancf.solve(scene({"material": NO_POISSON}, **straight(tension, (0.0, 0.0))))
    s = np.linalg.norm(solution.tip().r_x)
    assert EA * (s**2 - 1) * s / 2 == pytest.approx(-tension, rel=1e-9)
    assert solution.tendon_lengths() == pytest.approx([s * L], rel=1e-10)


def test_the_section_carries_thrust_and_couple():
    """At the axial points n = -T t and m = d x (-T t), t the tendon's direction there (statics)."""
    solution = ancf.solve(scene({"material": NO_POISSON}, **straight(TENSION, (0.005, 0.0))))
    forces = solution.section_forces()
    for at, n, m in zip(forces.at, forces.force, forces.moment, strict=True):
        pose = solution.pose(None, at)
        ahead = [solution.displaced(None, at + s, 0.005, 0.0) for s in (1e-6, -1e-6)]
        t = (ahead[0] - ahead[1]) / np.linalg.norm(ahead[0] - ahead[1])
        np.testing.assert_allclose(n, -TENSION * t, rtol=0, atol=1e-7 * TENSION)
        np.testing.assert_allclose(m, np.cross(0.005 * pose.r_y, n), rtol=0, atol=1e-6 * TENSION * 0.005)


@pytest.mark.parametrize("element", ["3333", "3243", "3363"])
def test_force_and_tangent_are_derivatives(element):
    """Q = -dV/de and K = dQ/de by central differences, at a random state."""
    model = Model(scene({"element": element, "curvature": [0.3, 1.0, -0.5]}, **tendon()))
    check_derivatives(model, strain=0.05, step=1e-6)
    assert model.conservative


@settings(deadline=None)
@given(st.lists(st.floats(-2, 2), min_size=6, max_size=6))
def test_a_tendon_turns_with_the_rod(numbers):
    """A rigid motion changes neither length nor, but for the turn, the forces; they balance."""
    model = Model(scene({"curvature": [0.3, 1.0, -0.5]}, **tendon()))
    fine = 1e-12 * TENSION
    check_rigid_motion(model, PulledTendon.length, numbers, 1e-13, fine, fine, arm=L)


def test_the_length_of_a_bent_path():
    """On a straight rod pulled by nothing: the length of a broken line in space (Pythagoras)."""
    solution = ancf.solve(scene(**tendon(tension=0.0)))
    points = np.array(PATH) * [L, 1, 1]
    exact = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert solution.tendon_lengths() == pytest.approx([exact], rel=1e-12)
    assert solution.as_dict()["tendons"] == [
        {"rod": "rod", "tension": 0.0, "length": pytest.approx(exact, rel=1e-12)}
    ]


def test_a_tendon_that_is_not_pulled_changes_nothing():
    tables = {"force": [{"value": [0, 0.5 * EI / L**2, 0]}]}
    with_it, without = ancf.solve(scene(**tables, **tendon(tension=0.0))), ancf.solve(scene(**tables))
    np.testing.assert_array_equal(with_it.q, without.q)
    assert "tendon" not in without.effects and with_it.effects["tendon"]["calls"] > 0


def test_pulled_in_one_step_or_in_many():
    tables = tendon() | {"force": [{"value": [0, 0, 1.0 * EI / L**2]}]}
    at_once, walked = ancf.solve(scene(**tables)), ancf.solve(scene(**tables, solver={"predictor": "none"}))
    assert at_once.steps == 1 and at_once.iterations <= 8
    np.testing.assert_allclose(walked.q, at_once.q, rtol=0, atol=1e-9)


def test_the_start_is_near():
    """A Kirchhoff chain bent by the tendon's couples is within 0.1 L where the tip has moved by half."""
    model = Model(scene({"elements": 8}, **straight(4 * TENSION, (0.003, -0.004))))
    start, solution = load_start(model), ancf.solve(model.scene)
    (rod,) = model.rods
    tips = [rod.nodal(q)[-1, 0] for q in (start, solution.q)]
    assert np.linalg.norm(tips[1] - [L, 0, 0]) > 0.5 * L
    assert np.linalg.norm(tips[0] - tips[1]) < 0.1 * L  # the start knows no thrust


def test_many_tendons_pull_together():
    """Two tendons across each other are one between them: the couples add."""
    d = 0.005
    two = {"tendon": [straight(TENSION, offset)["tendon"][0] for offset in ((d, 0.0), (0.0, d))]}
    one = straight(2 * TENSION, (d / 2, d / 2))
    tips = [ancf.solve(scene(**tables)).tip().position for tables in (two, one)]
    np.testing.assert_allclose(tips[0], tips[1], rtol=0, atol=1e-3 * L)
    assert tips[0][1] == pytest.approx(tips[0][2], rel=1e-6)


def test_results_and_units():
    scene_ = scene(**tendon(tension="500 mN", path=[[0, "5 mm", 0], [1, "5 mm", 0]]))
    assert scene_.tendons[0].tension == 0.5 and scene_.tendons[0].path[1].tolist() == [1.0, 0.005, 0.0]
    batch_refused = ancf.solve(scene_).as_dict()
    assert batch_refused["effects"]["tendon"]["calls"] >= 1


def test_sweeps_and_derivatives():
    """A batch of tensions is what `solve` finds; the sensitivity that of differences of solves."""
    tables = {"tendon": [*straight(0.0, (0.005, 0.0))["tendon"], *tendon()["tendon"]]}
    rows = np.array([[0.0, 0.5], [1.0, 0.0], [0.7, 1.2]]) * TENSION
    batch = ancf.solve_batch(scene(**tables), tensions=rows)
    assert (batch.status == "converged").all()

    def alone(pulls):
        for table, pull in zip(tables["tendon"], pulls, strict=True):
            table["tension"] = float(pull)
        return ancf.solve(scene(**tables))

    for row, pose in zip(rows, batch.poses, strict=True):
        np.testing.assert_allclose(pose[:, 0], alone(row).tip().position, rtol=0, atol=1e-10 * L)
    step = 1e-3 * TENSION
    for index in range(2):
        ends = [alone(rows[2] + s * step * np.eye(2)[index]).tip().position for s in (1, -1)]
        found = batch.sensitivity("tension", index)[2]
        assert found.shape == (12,)
        np.testing.assert_allclose(found[:3] * TENSION, (ends[0] - ends[1]) / 2e-3, rtol=0, atol=1e-6 * L)
    alone(rows[2])
    first = ancf.solve_batch(scene(**tables), tensions=rows[:, 0])
    np.testing.assert_allclose(
        first.poses[1, :, 0], alone([rows[1, 0], rows[2, 1]]).tip().position, atol=1e-9
    )


@pytest.mark.parametrize(
    ("tensions", "hint"),
    [
        ([[-1.0, 0.0]], "cannot push"),
        ([[[1.0]]], "wrong shape"),
        ([[1.0, 2.0, 3.0]], "(B, 2)"),
        ([[np.nan]], "finite"),
    ],
)
def test_bad_sweeps_are_refused(tensions, hint):
    tables = {"tendon": [*straight(1.0, (0.0, 0.0))["tendon"], *tendon()["tendon"]]}
    with pytest.raises(ancf.InputError) as refused:
        ancf.solve_batch(scene(**tables), tensions=tensions)
    assert hint in str(refused.value)


BAD = {
    "pushed": ({"tension": -1.0}, "tension"),
    "no path": ({"path": []}, "two or more"),
    "one point": ({"path": [[0, 0, 0]]}, "two or more"),
    "backwards": ({"path": [[1, 0, 0], [0, 0, 0]]}, "must rise"),
    "a pair": ({"path": [[0, 0], [1, 0]]}, "triple"),
    "outside": ({"path": [[0, 0, 0], [1, 0.0101, 0]]}, "leaves the section"),
    "beyond the rod": ({"path": [[0, 0, 0], [1.2, 0, 0]]}, "path[1][0]"),
    "another rod": ({"rod": "leg"}, "leg"),
    "tension and length": ({"length": 0.38}, "both a tension and a length"),
    "misspelt": ({"tensoin": 1.0}, "tension"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_tendons_are_refused(name):
    keys, hint = BAD[name]
    with pytest.raises(ancf.SceneError) as refused:
        scene(**tendon(**keys))
    assert hint in str(refused.value)


def test_a_tendon_in_the_bore_of_a_tube():
    tube = {"section": {"shape": "annulus", "radius": RADIUS, "inner_radius": 0.8 * RADIUS}}
    assert ancf.solve(scene(tube, **straight(0.1 * TENSION, (0.005, 0.0)))).status == "converged"
