"""Limits of ladders, and what one scene needs: nothing is claimed that the ladder does not show."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ancf.errors import InputError
from validation.cost import ladder
from validation.cost.limits import ROUNDING, ladder_limit
from validation.cost.points import CostPoint, milliseconds, point_dict, timed
from validation.cost.scene_record import advice, scene_dict

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@settings(deadline=None)
@given(st.floats(1.05, 5.5), st.floats(1e-3, 1.0), st.integers(1, 4), st.sampled_from([2, 3]))
def test_a_clean_ladder_gives_its_limit_and_order(order, size, first, ratio):
    """x_n = x + c n^-p: Richardson is exact, and the bar holds the error of the last mesh."""
    meshes = [first * ratio**k for k in range(4)]
    exact, direction = np.array([0.3, -0.2, 0.7]), np.array([0.6, 0.0, 0.8])
    values = [exact + size * n**-order * direction for n in meshes]
    found = ladder_limit(meshes, values)
    assert found is not None
    last = size * meshes[-1] ** -order
    if last > 10 * ROUNDING:
        assert found.order == pytest.approx(order, abs=1e-3)
        np.testing.assert_allclose(found.value, exact, atol=1e-3 * last)
        assert found.bar == pytest.approx(last, rel=1e-3)
    assert found.bar >= ROUNDING
    assert np.linalg.norm(found.value - exact) <= found.bar


@pytest.mark.parametrize(
    ("values", "bar"),
    [
        ([1.0, 1.1, 1.3], 0.2),  # differences grow
        ([1.0, 1.1, 1.2], 0.1),  # do not fall
        ([1.0, 1.1, 1.1 + 0.09], 0.09),  # fall with an order below one
    ],
)
def test_a_ladder_without_an_order_claims_its_last_difference(values, bar):
    found = ladder_limit([2, 4, 8], [np.array([v]) for v in values])
    assert found is not None
    assert found.value[0] == values[-1]
    assert found.bar == pytest.approx(bar)
    assert found.order is None or 0.0 < found.order < 1.0


def test_unequal_ratios_have_no_order():
    found = ladder_limit([3, 5, 10], [np.array([v]) for v in (1.0, 1.1, 1.11)])
    assert found is not None
    assert found.order is None and found.bar == pytest.approx(0.01)


def test_one_mesh_shows_nothing():
    assert ladder_limit([4], [np.zeros(3)]) is None


def test_refining_keeps_proportions_and_what_belongs_to_the_element():
    scene = {
        "rod": [
            {"segments": [{"elements": 2}, {"elements": 8}], "element": "3333", "axial_rule": 3},
            {"elements": 4, "shear_factors": [0.8, 0.8]},
        ],
        "solver": {"accuracy": 1e-3, "predictor": "none"},
    }
    own = ladder.refined_scene(scene, 16, "3333", "enhanced", True)
    assert [s["elements"] for s in own["rod"][0]["segments"]] == [4, 16]
    assert own["rod"][1]["elements"] == 8
    assert own["rod"][0]["axial_rule"] == 3
    assert own["solver"] == {"predictor": "none"}
    other = ladder.refined_scene(scene, 2, "3363", "continuum", False)
    assert [s["elements"] for s in other["rod"][0]["segments"]] == [1, 2]
    assert "axial_rule" not in other["rod"][0]
    assert "shear_factors" not in other["rod"][1]
    assert scene["rod"][0]["segments"][0]["elements"] == 2


def test_a_quarter_circle_is_judged_by_its_own_ladder():
    """The limit holds the fine answer; a mesh that is called good enough is, against a far finer one."""
    import ancf

    found = ladder.scene_cost(EXAMPLES / "quarter-circle.toml")
    own = found.own
    assert own is not None and own.limit is not None
    fine = ladder.refined_scene(
        {**_toml(EXAMPLES / "quarter-circle.toml")}, 128, own.element, own.formulation, True
    )
    tip = ancf.solve(ancf.scene_from_dict(fine)).tip().position / 0.4
    assert np.linalg.norm(tip - own.limit.value) <= own.limit.bar
    for point in own.points:
        assert point.error == point.discretisation + own.limit.bar
    for target in ladder.TARGETS:
        need = own.need(target)
        assert need is not None
        assert np.linalg.norm(np.array(need.position) - tip) <= target
        assert found.best(target) is not None
    record = scene_dict(found)
    assert [need["reached"] for need in record["needs"]] == [True, True, True]
    assert record["recommendation"].startswith("For 0.01 % of the length take")


def _toml(path):
    import tomllib

    return tomllib.loads(path.read_text())


def _point(element, elements, error, seconds):
    return CostPoint(
        element, "beam", "enhanced", elements, "", "analytic", "auto", "converged",
        error=error, median=seconds, fastest=seconds,
    )  # fmt: skip


def test_what_is_not_reached_is_said_and_other_limits_do_not_count():
    limit = ladder.LadderLimit(np.zeros(3), 1e-5, 4.0)
    own = ladder.ElementLadder("3333", "enhanced", [_point("3333", 4, 5e-3, 1.0)], limit)
    far = ladder.ElementLadder("3363", "continuum", [_point("3363", 2, 1e-5, 0.1)], limit, distance=2e-3)
    found = ladder.SceneCost("", ["rod"], [own, far])
    best = found.best(1e-2)
    assert best is not None and best[0].element == "3363"  # its limit agrees within 1 %
    assert found.best(1e-3) is None  # 3363 is there, but 2e-3 away from the scene's own element
    assert "0.1 % and 0.01 % were not reached" in advice(found)
    coarse = replace(own, points=[_point("3333", 2, 0.3, 1.0)])
    assert "not even show 1 %" in advice(replace(found, ladders=[coarse]))
    nothing = ladder.SceneCost("", ["rod"], [])
    assert advice(nothing) == "No mesh has an equilibrium."


def test_a_coarse_mesh_may_be_lucky():
    """An error that falls through the target and rises again to the model's own does not count."""
    limit = ladder.LadderLimit(np.zeros(3), 1e-5, 4.0)
    points = [_point("3333", n, error, n) for n, error in ((2, 5e-5), (4, 2e-4), (8, 1e-4), (16, 1e-4))]
    found = ladder.ElementLadder("3333", "enhanced", points, limit)
    for target, elements in ((1e-3, 2), (1e-4, 8)):
        need = found.need(target)
        assert need is not None and need.elements == elements
    assert found.need(7e-5) is None


def test_a_scene_without_equilibrium_has_no_limit(tmp_path):
    """A load that no element carries; a lighter one folds a cable back, and pulls it."""
    path = tmp_path / "crushed.toml"
    path.write_text(
        (EXAMPLES / "quarter-circle.toml").read_text().split("[[moment]]")[0]
        + "[[force]]\nat = 1.0\nvalue = [-1e300, 0, 0]\n[solver]\nmax_steps = 3\n"
    )
    found = ladder.scene_cost(path)
    assert not found.converged
    assert found.own is None
    assert len(found.omissions) >= len(found.ladders)
    assert scene_dict(found)["needs"][0] == {"target": 1e-2, "reached": False, "by_element": []}


def test_rods_of_different_elements_are_refused(tmp_path):
    path = tmp_path / "two.toml"
    rod = 'length = 1.0\nelements = 2\nsection = { shape = "circle", radius = 0.01 }\n'
    rod += "material = { young_modulus = 1e6, poisson_ratio = 0.3 }\n"
    path.write_text(f'[[rod]]\nname = "a"\n{rod}[[rod]]\nname = "b"\nelement = "3243"\n{rod}')
    with pytest.raises(InputError, match="different elements") as caught:
        ladder.scene_cost(path)
    message = caught.value.message
    assert all((message.what, message.where, message.value, message.cause, message.advice))


def test_a_slow_run_is_measured_once():
    calls = []

    def slow():
        calls.append(1)
        while len(calls) == 1 and sum(i for i in range(200_000)) and _used() < 0.4:
            pass

    import time

    begun = time.process_time()

    def _used():
        return time.process_time() - begun

    results, seconds = timed(slow, 5)
    assert len(calls) == len(results) == len(seconds) == 1
    assert len(timed(lambda: None, 3)[1]) == 3


def test_numbers_that_are_not_finite_become_null():
    found = point_dict(_point("3333", 4, math.inf, 1.0))
    assert found["error"] is None
    assert found["seconds"] == {"fastest": 1.0, "median": 1.0, "repeats": 0}


def test_times_in_words():
    assert milliseconds(0.00314) == "3.1 ms"
    assert milliseconds(0.314) == "314 ms"
    assert milliseconds(14.07) == "14 s"
