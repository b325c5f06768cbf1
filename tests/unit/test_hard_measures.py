"""Measures of the hard cases against what is known: orders, condition numbers, work, amplification."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import sparse

import ancf
from ancf.newton import Iteration
from validation import hard_measures, hard_walk
from validation.hard_scenes import arm, force, rolled


def solved(scene):
    solution = ancf.solve(ancf.scene_from_dict(scene))
    assert solution.status == "converged"
    return solution


@pytest.fixture(scope="module")
def quarter():
    return solved(rolled(math.pi / 2, elements=4))


# r_{k+1} = C r_k^p gives the order p, whatever C is.
@pytest.mark.parametrize(("order", "C"), [(2.0, 0.5), (2.0, 3.0), (1.0, 0.3), (1.5, 1.0)])
def test_the_order_of_a_synthetic_history(order, C):
    residuals = [1e-1]
    for _ in range(3):
        residuals.append(C * residuals[-1] ** order)
    assert hard_measures.newton_order(residuals, 1e-30) == pytest.approx(order, abs=1e-9)
    run = [Iteration(1.0, i + 1, 1.0, r) for i, r in enumerate(residuals)]
    assert hard_measures.step_order(run, 1e-30) == pytest.approx(order, abs=1e-9)


def test_residuals_outside_the_window_do_not_count():
    quadratic = [1e-1, 1e-2, 1e-4, 1e-8]
    assert hard_measures.newton_order([50.0, *quadratic], 1e-12) == pytest.approx(2.0)
    # The last residual is below 100 floors: the three before it tell the order, also if it is garbage.
    assert hard_measures.newton_order([*quadratic, 3e-9], 5e-11) == pytest.approx(2.0)
    assert hard_measures.newton_order(quadratic, 1e-3) is None  # all but one below 100 floors
    assert hard_measures.newton_order([1e-1, 2e-1, 1e-2, 1e-5], 1e-30) is None  # not falling three in a row
    assert hard_measures.newton_order([], 0.0) is None


def test_steps_behind_a_residual_at_its_floor_do_not_count():
    steps, floor = [1e-2, 1e-4, 1e-8, 9e-9], 1e-6
    residuals = [1e2, 1e-1, 2e-5, 5e-6]  # the last is below 10 floors
    run = [Iteration(1.0, i + 1, r, s) for i, (r, s) in enumerate(zip(residuals, steps, strict=True))]
    assert hard_measures.step_order(run, floor) == pytest.approx(2.0)
    assert hard_measures.step_order(run, 1e-5) is None


def test_the_last_run_is_taken():
    history = [Iteration(f, i, 1.0, 1.0) for f, i in ((0.5, 1), (0.5, 2), (1.0, 1), (1.0, 2), (1.0, 3))]
    assert hard_measures.last_run(history) == history[2:]
    assert hard_measures.last_run([]) == []


def test_the_order_of_a_solved_rod(quarter):
    """Newton with its exact tangent: the issue requires 1.8."""
    by_residuals, by_steps = hard_measures.observed_orders(quarter)
    assert by_residuals is None or by_residuals >= 1.8
    assert by_steps == pytest.approx(2.0, abs=0.2)


def hilbert(n):
    i = np.arange(n)
    return 1.0 / (1.0 + i[:, None] + i)


def test_the_condition_number_of_a_known_matrix():
    """1-norm condition number of the Hilbert matrix of order 4: 28375 (Todd 1961)."""
    assert hard_measures.condition_number(sparse.csc_array(hilbert(4))) == pytest.approx(28375.0, rel=1e-9)
    assert math.isinf(hard_measures.condition_number(sparse.csc_array(np.zeros((3, 3)))))


def test_the_estimate_for_large_matrices_is_that_of_small_ones(monkeypatch):
    rng = np.random.default_rng(5)  # any seed; the estimate is a lower bound, rarely below a third
    matrices = [hilbert(6) + np.diag(np.arange(6.0)) - 3.0 * np.eye(6, k=2), hilbert(5)]
    matrices += [rng.normal(size=(8, 8)) for _ in range(6)]
    exactly = 0
    for dense in matrices:
        matrix = sparse.csc_array(dense)
        monkeypatch.setattr(hard_measures, "DENSE", 800)
        exact = hard_measures.condition_number(matrix)
        monkeypatch.setattr(hard_measures, "DENSE", 0)
        share = hard_measures.condition_number(matrix) / exact
        assert 1.0 / 3.0 < share < 1.0 + 1e-9
        exactly += share > 1.0 - 1e-9
    assert exactly >= 6  # Higham: exact for most


def test_the_tangent_is_dimensionless():
    """The same rod in other units of length and another modulus has the same matrix."""
    one = hard_measures.dimensionless_tangent(solved(arm(elements=3))).toarray()
    large = arm(elements=3, young=2e9, length=40.0, section={"shape": "circle", "radius": 1.0})
    other = hard_measures.dimensionless_tangent(solved(large)).toarray()
    assert other == pytest.approx(one, rel=1e-9, abs=1e-9 * np.abs(one).max())
    # P L^3/(3 E I): the tip moves by a third for a unit load, here through the inverse of the matrix.
    solution = solved(arm(400, elements=8, force=[force([0, 1e-6, 0], 400)]))
    column = np.zeros(solution.unknowns)
    column[-8] = 1.0  # y of the last node: its three vectors are the last nine unknowns
    inverse = np.linalg.solve(hard_measures.dimensionless_tangent(solution).toarray(), column)
    assert inverse[-8] == pytest.approx(1.0 / 3.0, rel=2e-3)  # Euler-Bernoulli; shear (R/L)^2, mesh


def test_the_amplification_of_a_linear_load():
    """Small tip force: the displacement is linear in the load, so d u/d ln f = u."""
    solution = solved(arm(elements=4, force=[force([0, 1e-3, 0])]))
    u = np.linalg.norm(solution.tip().position - [0.4, 0, 0]) / 0.4
    assert hard_measures.load_amplification(solution) == pytest.approx(u, rel=1e-4)
    assert hard_measures.load_amplification(solved(arm(elements=4))) == 0.0


def test_the_smallest_volume_ratio():
    assert hard_measures.smallest_volume_ratio(solved(arm(elements=2))) == pytest.approx(1.0, abs=1e-12)


# --- the walk ---------------------------------------------------------------------------------------------


def test_work_of_a_known_path():
    """Force q^3 along q = t^2: W = q^4/4; trapezoid of order 2, Simpson of order 4."""

    def work(n):
        q = np.linspace(0.0, 1.0, n + 1)[:, None] ** 2
        return hard_walk.trapezoid(q, q**3)

    found = hard_walk.balance([work(n) for n in (25, 50, 100)], 0.25)
    assert found.trapezoid_order == pytest.approx(2.0, abs=0.01)
    assert found.simpson_order == pytest.approx(4.0, abs=0.1)
    assert found.error < 1e-6 < found.trapezoid_error
    # errors .1, .04, .01: the order of the last two is 2
    assert hard_walk.balance([1.1, 1.04, 1.01], 1.0).trapezoid_order == pytest.approx(2.0)


def test_a_balance_that_is_not_met_has_no_order():
    """A wrong factor in the energy leaves an error that does not fall."""
    found = hard_walk.balance([1.01, 1.0025, 1.000625], 0.5)
    assert found.error == pytest.approx(1.0, abs=1e-3)
    assert abs(found.trapezoid_order) < 0.1
    exact = hard_walk.balance([1.0, 1.0, 1.0], 1.0)
    assert exact.error == 0.0
    assert exact.trapezoid_order is exact.simpson_order is None
    assert hard_walk.balance([1e-40, 0.0, 0.0], 1e-38, 1e-12).error < 1e-20  # nothing to balance


@pytest.mark.parametrize("direction", ["fixed", "follower"])
def test_the_energy_balance_of_a_walk(direction):
    """Work of any load is strain energy on a path of equilibria, with a potential or without."""
    scene = arm(elements=4, force=[force([0, 2.0, 1.0], direction=direction)])
    path = hard_walk.walk(scene, 20)
    found = hard_walk.energy_balance(path, (5, 10, 20))
    assert found.trapezoid_order == pytest.approx(2.0, abs=0.1)
    assert found.error < 1e-4
    answer = solved(scene)
    assert np.abs(path[-1].q - answer.q).max() < 1e-9 * 0.4
    with pytest.raises(ValueError, match="walk of 40 steps"):
        hard_walk.energy_balance(path, (10, 20, 40))


def test_every_load_is_scaled():
    scene = arm(
        moment=[{"value": [2.0, 0, 0]}], force=[{"value": [0, 4.0, 0]}],
        line_load=[{"value": [0, 0, 6.0]}], gravity={"acceleration": [0, 0, -8.0]},
    )  # fmt: skip
    half = hard_walk.scaled(scene, 0.5)
    assert half["moment"][0]["value"] == [1.0, 0, 0]
    assert half["force"][0]["value"] == [0, 2.0, 0]
    assert half["line_load"][0]["value"] == [0, 0, 3.0]
    assert half["gravity"]["acceleration"] == [0, 0, -4.0]
    assert scene["force"][0]["value"] == [0, 4.0, 0]


def test_a_walk_begins_each_step_at_the_last(monkeypatch):
    starts, options = [], []

    def spy(scene, start=None):
        starts.append(start)
        options.append(scene.solver.predictor)
        return solve(scene, start=start)

    solve = ancf.solve
    monkeypatch.setattr(ancf, "solve", spy)
    path = hard_walk.walk(rolled(0.5, elements=2), 3)
    assert starts[0] is None
    assert all(start is solution.q for start, solution in zip(starts[1:], path[:-1], strict=True))
    assert options == ["none"] * 3


def test_a_walk_ends_where_there_is_no_equilibrium():
    """0.3 E A of compression: Saint Venant-Kirchhoff carries 0.19245, 64 % of it."""
    P = 0.3 * 1e6 * math.pi * 0.01**2
    scene = arm(elements=2, force=[{"value": [-P, 0, 0]}], solver={"max_steps": 40})
    assert len(hard_walk.walk(scene, 5)) == 3
