"""Rotational springs and beds: closed forms, exact derivatives, axes, half a turn, refusals."""

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

import ancf
from ancf.effects.foundation import ElasticFoundation
from ancf.effects.rotational_bed import RotationalBed
from ancf.effects.rotational_spring import RotationalSpring
from ancf.effects.spring import ReferenceSpring
from ancf.model import Model
from ancf.rotation import exp, log
from ancf.rotation_vector import coefficient, rate, spring_moment, spring_moment_change
from ancf.turning_springs import MOST_TURN
from reference.foundation import turned_cantilever_tip, turned_on_bed
from tests.effect_checks import blocks, check_derivatives

L, RADIUS, YOUNG = 1.0, 0.0025, 1e6
EI = YOUNG * np.pi * RADIUS**4 / 4
GJ = EI  # at nu = 0
K = 2.0 * EI / L


def scene(rod=None, **tables):
    data = {
        "length": L, "elements": 16, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.0, "density": 1000.0},
    } | (rod or {})  # fmt: skip
    return ancf.scene_from_dict({"rod": [data], **tables})


ANGLES = st.lists(st.floats(-1, 1), min_size=3, max_size=3).filter(lambda v: np.linalg.norm(v) > 0.01)


@settings(deadline=None)
@given(ANGLES, st.floats(0.0, 3.0), st.lists(st.floats(-1, 1), min_size=9, max_size=9))
@example([1.0, 0.0, 0.0], 0.0, [1.0, 0.5, 0.0, 0.5, 2.0, 0.0, 0.0, 0.0, 3.0])
@example([0.6, -0.3, 0.5], 3.0, [1.0, 0.5, 0.0, 0.5, 2.0, 0.0, 0.0, 0.0, 3.0])
def test_rate_and_moment_are_derivatives(axis, angle, entries):
    """dtheta = L dw; m = -dV/dw; dm/dw: by central differences of log and exp, over all of half a turn."""
    theta = angle * np.array(axis) / np.linalg.norm(axis)
    A = np.array(entries).reshape(3, 3)
    k, R, h = A @ A.T + 0.1 * np.eye(3), exp(theta), 1e-6
    m, D = spring_moment(theta, k), spring_moment_change(theta, k)
    for i, w in enumerate(np.eye(3)):
        after, before = (log(exp(s * h * w) @ R) for s in (1, -1))
        scale = np.linalg.norm(k)
        np.testing.assert_allclose((after - before) / (2 * h), rate(theta)[:, i], rtol=0, atol=1e-7)
        slope = (after @ k @ after - before @ k @ before) / (4 * h)
        assert -m[i] == pytest.approx(slope, abs=1e-7 * scale)
        change = (spring_moment(after, k) - spring_moment(before, k)) / (2 * h)
        np.testing.assert_allclose(D[:, i], change, rtol=0, atol=1e-7 * scale)


def test_the_coefficient_is_its_closed_form():
    """c = (1 - (a/2) cot(a/2))/a^2 and c'/a where cancellation leaves digits; 1/12 and 1/360 at zero."""
    a = np.array([0.5, 1.0, 2.0, 3.0, np.pi])
    c, slope = coefficient(a)
    np.testing.assert_allclose(c, (1 - a / 2 / np.tan(a / 2)) / a**2, rtol=1e-13)
    exact = (-2 * c + (a / 4 / np.sin(a / 2) ** 2 - 0.5 / np.tan(a / 2)) / a) / a**2
    np.testing.assert_allclose(slope, exact, rtol=1e-11)
    np.testing.assert_allclose(coefficient(np.zeros(1)), [[1 / 12], [1 / 360]], rtol=1e-14)


def test_equal_stiffnesses_turn_straight_back():
    """m = -k theta, at any angle; energy 1/2 k |theta|^2."""
    theta = np.array([1.3, -0.7, 2.1])
    np.testing.assert_allclose(spring_moment(theta, 3.0 * np.eye(3)), -3.0 * theta, rtol=1e-14)


@pytest.mark.parametrize("element", ["3333", "3343", "3363", "3243"])
def test_a_cantilever_on_a_rotational_spring(element):
    """A small force on the end, which a spring keeps from turning (reference/foundation.py)."""
    P = 1e-4 * EI / L**2
    solution = ancf.solve(
        scene(
            {"element": element},
            force=[{"value": [0, P, 0]}],
            spring=[{"rotational_stiffness": K}],
            solver={"reduction": "full"},
        )
    )
    w, turn = turned_cantilever_tip(L, EI, P, K)
    # 3243 locks at L/R = 400: 0.3 to 4 % (theory.md 3); the others by shear, 12 E I/(G A L^2) = 4e-5.
    limit = 5e-2 if element == "3243" else 2e-4
    assert solution.tip().position[1] == pytest.approx(w, rel=limit)
    (entry,) = solution.as_dict()["springs"]
    assert entry["rotation"][2] == pytest.approx(turn, rel=limit)
    np.testing.assert_allclose(entry["moment"], -K * np.array(entry["rotation"]), rtol=1e-12, atol=0)
    np.testing.assert_allclose(entry["force"], 0.0, atol=0)
    assert solution.stable and solution.balance().relative < 1e-10


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 0, 1], [0.6, 0.0, 0.8]])
def test_a_couple_against_a_spring_of_equal_stiffness(axis):
    """M - k phi is constant along a thin rod: phi (k + E I/L) = M about an axis, however far (GJ = E I)."""
    phi = 2.5
    M = phi * (K + EI / L)
    tables = {"moment": [{"value": (M * np.array(axis)).tolist()}], "spring": [{"rotational_stiffness": K}]}
    solution = ancf.solve(scene(**tables))
    assert solution.status == "converged" and solution.stable is not False
    turn = solution.as_dict()["springs"][0]["rotation"]
    np.testing.assert_allclose(turn, phi * np.array(axis), rtol=0, atol=1e-3)  # (phi R/L)^2 = 4e-5, and mesh


@pytest.mark.parametrize("element", ["3333", "3343", "3363"])
@pytest.mark.parametrize("axis", [0, 2])
def test_a_rod_turned_on_a_bed(element, axis):
    """b L = 3: theta = C sinh(b x)/(S b cosh(b L)) along the rod, in twist and, 2 rad far, in bending."""
    bed, turn = 9.0 * EI / L**2, 2.0
    couple = turn * 3.0 * EI / L / np.tanh(3.0)
    moment = [{"value": (couple * np.eye(3)[axis]).tolist()}]
    solution = ancf.solve(
        scene(
            {"element": element, "elements": 24},
            moment=moment,
            foundation=[{"rotational_stiffness": bed}],
            solver={"reduction": "full"},
        )
    )
    assert solution.status == "converged"
    at = np.array([0.3, 0.6, 0.8, 1.0])
    found = [log(solution.pose(None, float(s)).rotation)[axis] for s in at]
    exact = turned_on_bed(at * L, L, EI, bed, couple)
    np.testing.assert_allclose(found, exact, rtol=0, atol=2e-4 * turn)  # (kappa R)^2 = 2e-4 at the end
    entry = solution.as_dict()["foundations"][0]
    assert entry["moment"][axis] == pytest.approx(-couple * (1 - 1 / np.cosh(3.0)), rel=2e-3)
    assert entry["rotation"] == pytest.approx(turn, rel=2e-2)  # at its last point


def test_part_of_a_rod_on_a_bed():
    """A bed from 0.41 to 0.68 under a rod turned rigidly by theta carries -k theta 0.27 L."""
    table = {"rotational_stiffness": [3.0, 3.0, 3.0], "from": 0.41, "to": 0.68}
    model = Model(scene(foundation=[table]))
    (bed,) = model.effects
    assert isinstance(bed, RotationalBed)
    theta = np.array([0.3, -1.1, 0.8])
    q = model.q0.reshape(-1, 3) @ exp(theta).T
    e = blocks(model, bed, q.ravel())
    np.testing.assert_allclose(bed.report(e)["moment"], -0.81 * L * theta, rtol=1e-12)
    assert bed.potential(e) == pytest.approx(0.5 * 0.81 * L * theta @ theta, rel=1e-12)


def test_a_bed_is_many_springs():
    """16 springs on the middles of pieces against the bed (midpoint rule, second order)."""
    bed, count = 5.0 * EI / L**2, 64
    P = 2.0 * EI / L**2
    springs = [{"at": (i + 0.5) / count, "rotational_stiffness": bed * L / count} for i in range(count)]
    load = {"force": [{"value": [0, P, 0.5 * P]}]}
    one = ancf.solve(scene(foundation=[{"rotational_stiffness": bed}], **load))
    many = ancf.solve(scene({"elements": count}, spring=springs, **load))
    np.testing.assert_allclose(one.tip().position, many.tip().position, rtol=0, atol=5e-4 * L)


CASES = {
    "spring": {"spring": [{"at": 0.3, "rotational_stiffness": [1.0, 2.0, 3.0]}]},
    "both": {"spring": [{"at": 0.7, "stiffness": 5.0, "rotational_stiffness": 0.1, "frame": "body"}]},
    "bed": {
        "foundation": [
            {"rotational_stiffness": [1.0, 2.0, 3.0], "frame": "section", "from": 0.11, "to": 0.8}
        ]
    },
    "both beds": {"foundation": [{"stiffness": 9.0, "rotational_stiffness": [0.1, 0.0, 0.3]}]},
}  # fmt: skip
TILTED = {"position": [1, 2, 3], "x_axis": [1, 2, 0.5], "y_axis": [0, 1, -1]}


@pytest.mark.parametrize("element", ["3333", "3243", "3363", "3343"])
@pytest.mark.parametrize("name", CASES)
def test_force_and_tangent_are_derivatives(name, element):
    rod = {"element": element, "elements": 5, "curvature": [1.0, 2.0, -1.0], "base": TILTED}
    model = Model(scene(rod, **CASES[name]))
    assert isinstance(model.effects[0], RotationalSpring | RotationalBed)
    check_derivatives(model, strain=0.05, step=1e-5)
    q = model.q0.reshape(-1, 3) @ exp(np.array([0.9, -1.2, 1.7])).T  # 2.3 rad
    (effect,) = model.effects
    e = blocks(model, effect, q.ravel())
    way = np.random.default_rng(4).uniform(-1, 1, e.shape) * blocks(model, effect, model.unit)
    Q, tangent = effect.force_and_tangent(e)
    h = 1e-5
    slope = (effect.potential(e + h * way) - effect.potential(e - h * way)) / (2 * h)
    assert -np.sum(Q * way) == pytest.approx(slope, rel=1e-6)
    np.testing.assert_allclose(tangent, np.swapaxes(tangent, 1, 2), atol=1e-12 * np.abs(tangent).max())
    assert model.conservative and all(one.passive for one in model.effects)


@settings(deadline=None, max_examples=20)
@given(st.lists(st.floats(-1.5, 1.5), min_size=3, max_size=3), st.sampled_from(sorted(CASES)))
def test_a_turned_scene_has_a_turned_answer(numbers, name):
    """With the ground's axes of the rod the energy does not see how all of it is turned."""
    turn = exp(np.array(numbers))
    tables = {key: [table | {"frame": "body"} for table in value] for key, value in CASES[name].items()}
    found = []
    for A in (np.eye(3), turn):
        base = {"x_axis": A[:, 0].tolist(), "y_axis": A[:, 1].tolist()}
        model = Model(scene({"elements": 4, "curvature": [0.0, 1.0, 0.5], "base": base}, **tables))
        bent = np.random.default_rng(1).uniform(-0.05, 0.05, (model.n // 3, 3))
        q = model.q0.reshape(-1, 3) + bent @ A.T
        (effect,) = model.effects
        e = blocks(model, effect, q.ravel())
        found.append((effect.potential(e), effect.force(e) @ A))
    assert found[1][0] == pytest.approx(found[0][0], rel=1e-9)
    np.testing.assert_allclose(found[1][1], found[0][1], rtol=0, atol=1e-9 * np.abs(found[0][1]).max())


def test_axes_of_a_stiffness():
    """A soft axis turns freely; in body axes the base turns it, in section axes the curvature does too."""
    base = {"x_axis": [0, 1, 0], "y_axis": [0, 0, 1]}
    A = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], float).T
    turned = A @ exp(np.array([0, 0, 2.0]))
    curved = {"base": base, "curvature": [0, 0, 2.0]}
    for frame, axes in (("structure", np.eye(3)), ("body", A), ("section", turned)):
        table = {"rotational_stiffness": [1.0, 2.0, 3.0], "frame": frame, "from": 0.999999}
        (bed,) = Model(scene(curved, foundation=[table])).effects
        np.testing.assert_allclose(bed.turning.k[0], axes @ np.diag([1.0, 2.0, 3.0]) @ axes.T, atol=1e-5)
    (spring,) = Model(scene(curved, spring=[{"rotational_stiffness": [1, 2, 3], "frame": "body"}])).effects
    np.testing.assert_allclose(spring.turning.k[0], A @ np.diag([1.0, 2.0, 3.0]) @ A.T, atol=1e-15)


def test_a_stiff_spring_is_a_clamp():
    """Both stiff at the end: the rod clamped at both ends, under a large force in the middle."""
    force = [{"at": 0.5, "value": [0, 40 * EI / L**2, 0]}]
    stiff = [{"stiffness": 1e9 * EI / L**3, "rotational_stiffness": 1e6 * EI / L}]
    held = ancf.solve(scene(force=force, spring=stiff))
    clamps = [{"at": 0.0, "kind": "clamp"}, {"at": 1.0, "kind": "free_section_clamp"}]
    clamped = ancf.solve(scene({"supports": clamps}, force=force))
    assert held.status == "converged"
    np.testing.assert_allclose(held.pose(None, 0.5).position, clamped.pose(None, 0.5).position, atol=1e-4)


def test_beyond_half_a_turn_there_is_a_reason():
    """One turn bent by a couple, against a weak spring: theta would be 2 pi, and seems to be 0."""
    M = 2.0 * np.pi * (EI / L + 0.01 * EI / L)
    tables = {"moment": [{"value": [0, 0, M]}], "spring": [{"rotational_stiffness": 0.01 * EI / L}]}
    solution = ancf.solve(scene(**tables))
    assert solution.status == "not_converged"
    assert "more than 3 rad" in solution.reason and "half a turn" in solution.reason
    # The last equilibrium is the last one that the spring knows: theta = lambda M/(k + E I/L).
    reached = 2.0 * np.pi * solution.load_factor
    assert MOST_TURN - 0.1 < reached <= MOST_TURN + 1e-3
    below = M * (MOST_TURN - 0.02) / (2.0 * np.pi)
    assert ancf.solve(scene(moment=[{"value": [0, 0, below]}], spring=tables["spring"])).status == "converged"


@pytest.mark.parametrize("turns", [1.0, -1.0, 2.0])
def test_turns_are_followed_along_the_rod(turns):
    """A rod rolled up to whole turns is not taken for a straight one."""
    rolled = ancf.solve(scene({"elements": 32}, moment=[{"value": [0, 0, 2 * np.pi * turns * EI / L]}]))
    model = Model(
        scene(
            {"elements": 32}, spring=[{"rotational_stiffness": K}, {"at": 0.1875, "rotational_stiffness": K}]
        )
    )
    first, second = model.effects
    assert first.turning.turns(rolled.q)[0, 0] == pytest.approx(2 * np.pi * abs(turns), rel=2e-3)
    assert second.turning.turns(rolled.q)[0, 0] == pytest.approx(0.375 * np.pi * abs(turns), rel=2e-3)
    assert not first.is_known(rolled.q) and second.is_known(rolled.q) and not model.is_known(rolled.q)


@pytest.mark.parametrize("clamp", [0.5, 1.0])
def test_turns_are_followed_towards_the_base(clamp):
    """The same of a rod that is clamped at its middle or end and rolled up from its base."""
    rod = {"elements": 32, "supports": [{"at": clamp}]}
    rolled = ancf.solve(scene(rod, moment=[{"at": 0.0, "value": [0, 0, 2 * np.pi * EI / (clamp * L)]}]))
    assert rolled.status == "converged"
    model = Model(scene(rod, spring=[{"at": at, "rotational_stiffness": K} for at in (0.0, 0.25 * clamp)]))
    turns = [effect.turning.turns(rolled.q)[0, 0] for effect in model.effects]
    np.testing.assert_allclose(turns, [2 * np.pi, 1.5 * np.pi], rtol=3e-3)


def test_no_stiffness_changes_nothing():
    tables = {"force": [{"value": [0, 0.5 * EI / L**2, 0]}], "solver": {"reduction": "full"}}
    nothing = {
        "spring": [{"at": 0.37, "rotational_stiffness": 0.0}],
        "foundation": [{"stiffness": 0.0, "rotational_stiffness": [0.0, 0.0, 0.0]}],
    }
    with_it, without = ancf.solve(scene(**tables, **nothing)), ancf.solve(scene(**tables))
    np.testing.assert_array_equal(with_it.q, without.q)
    assert [type(effect) for effect in with_it.model.effects[1:]] == [ReferenceSpring, ElasticFoundation]


def test_batches_sensitivities_and_paths():
    held = {
        "spring": [{"at": 0.5, "rotational_stiffness": K}],
        "foundation": [{"rotational_stiffness": 3 * EI / L**2}],
    }
    P = EI / L**2

    def solved(value, **more):
        return ancf.solve(scene(force=[{"value": value}], **held, **more))

    solution = solved([0, P, 0.2 * P])
    batch = ancf.solve_batch(solution.scene, forces=[[0, P, 0.2 * P], [0, 3 * P, 0]])
    assert all(status == "converged" for status in batch.status)
    np.testing.assert_allclose(batch.poses[0, :, 0], solution.tip().position, atol=1e-9)
    h = 1e-3 * P
    more, less = (solved([0, P + d, 0.2 * P]).tip().position for d in (h, -h))
    slope = (more - less) / (2 * h)
    np.testing.assert_allclose(solution.sensitivity("force")[:3, 1], slope, rtol=1e-5, atol=1e-9 * L / P)
    followed = solved([0, P, 0.2 * P], solver={"method": "arclength"})
    np.testing.assert_allclose(followed.tip().position, solution.tip().position, rtol=0, atol=1e-8)


def test_a_spring_holds_a_column():
    """Euler's load of a column clamped at 0 with a rotational spring on its free end: u tan u = -k L/E I."""
    from scipy.optimize import brentq

    k = 2.0
    u = brentq(lambda u: u * np.cos(u) + k * np.sin(u), np.pi / 2, np.pi - 1e-9)  # between free and guided
    for share, stable in ((0.99, True), (1.01, False)):
        tables = {"force": [{"value": [-share * u**2 * EI / L**2, 0, 0]}]}
        solution = ancf.solve(scene(spring=[{"rotational_stiffness": k * EI / L}], **tables))
        assert solution.stable is stable


BAD = {
    "negative": ({"spring": [{"rotational_stiffness": -1.0}]}, "rotational_stiffness"),
    "two": ({"spring": [{"rotational_stiffness": [1.0, 2.0]}]}, "exactly 3"),
    "nan": ({"foundation": [{"rotational_stiffness": float("nan")}]}, "finite"),
    "unit": ({"spring": [{"rotational_stiffness": "3 N/m"}]}, "rotational stiffness"),
    "bed unit": ({"foundation": [{"rotational_stiffness": "3 N m/rad"}]}, "per length"),
    "anchor": (
        {"spring": [{"stiffness": 1.0, "rotational_stiffness": 1.0, "anchor": [0, 0, 0]}]},
        "to an anchor",
    ),
    "misspelt": ({"spring": [{"rotation_stiffness": 1.0}]}, "rotational_stiffness"),
    "nothing": ({"foundation": [{}]}, "stiffness"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_stiffnesses_are_refused(name):
    tables, hint = BAD[name]
    with pytest.raises(ancf.SceneError) as refused:
        scene(**tables)
    assert hint in str(refused.value) and "try:" in str(refused.value)


@pytest.mark.parametrize("table", ["spring", "foundation"])
def test_a_cable_is_not_turned(table):
    with pytest.raises(ancf.SceneError, match="No spring turns a cable"):
        scene({"element": "cable"}, **{table: [{"rotational_stiffness": 1.0}]})


def test_units():
    read = scene(
        spring=[{"rotational_stiffness": "3 N mm/rad"}],
        foundation=[{"rotational_stiffness": ["3 N mm/rad/m", 0, 1]}],
    )
    np.testing.assert_allclose(read.springs[0].rotational_stiffness, 3e-3 * np.eye(3), rtol=1e-15)
    np.testing.assert_allclose(read.foundations[0].rotational_stiffness, [3e-3, 0, 1], rtol=1e-15)
