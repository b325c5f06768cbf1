"""The hard cases: declared whole, judged by how they end, and every way of failing fails."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import ancf
from validation import hard_cases as module, hard_threads, hard_walk, runner
from validation.criteria import Limit, Verdict
from validation.evidence import evidence_of, limit_faults, verdict_of
from validation.expected import Expectation
from validation.hard_case import TYPED, HardCase
from validation.hard_cases import HardResult, hard_cases, judged, run_hard_case, solve_case
from validation.hard_limits import MEASURES, WALKED, hard_limits
from validation.hard_measures import smallest_volume_ratio
from validation.hard_scenes import arm, from_arc, rolled
from validation.journal import keep, revive
from validation.record import as_dict

QUARTER = HardCase(
    "test", "quarter", rolled(math.pi / 2, elements=4), "a quarter circle",
    limits=(Limit("deviation", 5e-3, "L", "finite strain (theory.md 2)", kind="non-regression"),),
    deviation=from_arc(math.pi / 2), walk="quick",
)  # fmt: skip
HUGE = HardCase("test", "huge", arm(force=[{"value": [0, 1e300, 0]}]), "overflows", TYPED, "stiffness")


@pytest.fixture
def one_process(monkeypatch):
    """The shapes of both thread counts from this process, so that a test solves one case and not all."""

    def shapes_with(threads):
        case = QUARTER
        return {case.name: module.shape_of(solve_case(case, case.scene))}

    monkeypatch.setattr(hard_threads, "shapes_with", shapes_with)
    monkeypatch.setattr(hard_walk, "STEPS", 20)
    monkeypatch.setattr(hard_walk, "RULES", (5, 10, 20))
    monkeypatch.setattr(module.hard_walk.walk, "__defaults__", (20,))
    monkeypatch.setattr(module.hard_walk.energy_balance, "__defaults__", ((5, 10, 20),))


def test_every_case_says_what_and_why():
    cases = hard_cases()
    assert len(cases) >= 75  # the families of the issue
    for case in cases:
        assert case.meaning
        assert case.family
        assert case.expected
        assert "out_of_time" not in case.expected
        assert all(limit.reason for limit in case.limits)
        assert (case.deviation is None) == all(limit.quantity != "deviation" for limit in case.limits)
        known = {m.name for m in MEASURES} | {"iterations"}
        assert {limit.quantity for limit in case.limits} <= known
        assert set(case.not_asked) <= known
        assert all(case.not_asked.values())
        if not case.solvable:
            assert case.said or case.expected == TYPED  # a failure for the right reason
            assert not case.limits


def test_every_case_ends_as_it_must():
    """Statuses, reasons, stability and exact answers of all; what is measured besides is in the report."""
    wrong = []
    for case in hard_cases():
        try:
            solution = solve_case(case, case.scene)
        except ancf.InputError as error:
            fault = module.ending_fault(case, "refused", str(error))
        else:
            fault = module.solution_fault(case, solution)
            if not fault and case.deviation is not None:
                limit = next(k.value for k in case.limits if k.quantity == "deviation")
                found = case.deviation(solution)
                fault = "" if found <= limit else f"deviation {found:.2e} > {limit}"
        if fault:
            wrong.append((case.name, fault))
    assert not wrong


def test_a_case_that_holds(one_process):
    result = run_hard_case(QUARTER, full=True)
    assert result.verdict in (Verdict.PASS, Verdict.WARN)
    assert result.fault == ""
    assert [f.quantity for f in result.findings] == [limit.quantity for limit in hard_limits(QUARTER)]
    assert set(result.measured) >= {m.name for m in MEASURES}
    assert all(value is not None for value in result.measured.values())
    assert 0.0 < result.measured["drift, turned"] < 1e-9  # the limit; 0 would be no other scene
    assert result.measured["energy order"] == pytest.approx(2.0, abs=0.1)
    assert result.history[-1].load_factor == 1.0


def test_a_quick_run_leaves_the_walk_to_the_chosen_cases(one_process):
    with_walk = run_hard_case(QUARTER)
    without = run_hard_case(replace(QUARTER, walk="full"))
    assert set(WALKED) <= set(with_walk.measured)
    assert not set(WALKED) & set(without.measured)
    assert "drift, one ulp" not in with_walk.measured
    for case, result in ((QUARTER, with_walk), (replace(QUARTER, walk="full"), without)):
        assert [f.quantity for f in result.findings] == [k.quantity for k in hard_limits(case, full=False)]


def test_the_own_limit_replaces_the_common_one():
    own = Limit("energy balance", 0.5, "U", "this test")
    found = {k.quantity: k for k in hard_limits(replace(QUARTER, limits=(own,)))}
    assert found["energy balance"] is own
    assert "energy balance" not in {k.quantity for k in hard_limits(replace(HUGE, limits=(own,)))}
    asked = hard_limits(replace(QUARTER, not_asked={"energy balance": "this test"}))
    assert "energy balance" not in {k.quantity for k in asked}


@pytest.mark.parametrize(
    ("case", "words"),
    [
        (replace(HUGE, expected=("converged",), said=""), "ended not_finite, must end in converged"),
        (replace(QUARTER, expected=("limit_point",)), "ended converged, must end in limit_point"),
        (replace(HUGE, said="no such words"), "does not say 'no such words'"),
        (replace(HUGE, scene=arm(supports=[])), "ended refused"),
    ],
)
def test_a_wrong_ending_fails(case, words, one_process):
    result = run_hard_case(case)
    assert result.verdict is Verdict.FAIL
    assert words in result.fault


def test_a_refusal_for_the_right_reason_passes():
    case = HardCase("test", "none", arm(supports=[]), "no support", ("refused",), "supports")
    assert run_hard_case(case).verdict is Verdict.PASS
    assert run_hard_case(replace(case, said="clamped twice")).verdict is Verdict.FAIL


def test_a_crash_is_a_failure_and_not_a_crash(monkeypatch):
    monkeypatch.setattr(module, "solve_case", lambda case, scene: 1 / 0)
    result = run_hard_case(QUARTER)
    assert (result.verdict, result.status) == (Verdict.FAIL, "exception")
    assert "ZeroDivisionError" in result.fault


def test_a_measure_that_crashes_fails(monkeypatch, one_process):
    monkeypatch.setattr(module.hard_measures, "load_amplification", lambda solution: 1 / 0)
    result = run_hard_case(QUARTER, full=True)
    assert result.verdict is Verdict.FAIL
    assert "not measured: ZeroDivisionError" in result.fault
    json.dumps(keep(result), allow_nan=False)


@pytest.mark.parametrize("value", [None, math.nan, math.inf, 1e-8])
def test_a_number_that_is_missing_not_finite_or_too_large_fails(value):
    limit = next(k for k in hard_limits(QUARTER) if k.quantity == "drift, turned")
    (finding,) = judged((limit,), {"drift, turned": value})
    assert finding.verdict is Verdict.FAIL
    (good,) = judged((limit,), {"drift, turned": 1e-12})
    assert good.verdict is Verdict.PASS
    (absent,) = judged((limit,), {})
    assert absent.verdict is Verdict.FAIL


def test_a_variant_without_an_answer_fails(monkeypatch, one_process):
    """A drift is never skipped because the other scene was not solved."""
    impossible = {"turned": lambda scene: module.hard_drift.Variant(HUGE.scene, lambda shape: shape)}
    monkeypatch.setattr(module, "VARIANTS", {**module.VARIANTS, **impossible})
    result = run_hard_case(QUARTER)
    assert result.verdict is Verdict.FAIL
    assert result.measured["drift, turned"] is None
    assert "not_finite" in result.notes["drift, turned"]


def test_threads_that_differ_fail(monkeypatch, one_process):
    right = hard_threads.shapes_with(1)
    wrong = {name: [r + 1e-8 for r in shape] for name, shape in right.items()}
    monkeypatch.setattr(hard_threads, "shapes_with", lambda threads: wrong if threads == 2 else right)
    assert run_hard_case(QUARTER).measured["drift, threads"] == pytest.approx(3**0.5 * 1e-8 / 0.4)
    monkeypatch.setattr(hard_threads, "shapes_with", lambda threads: {})
    result = run_hard_case(QUARTER)
    assert (result.verdict, result.measured["drift, threads"]) == (Verdict.FAIL, None)


def test_the_worst_ulp_counts(monkeypatch, one_process):
    """One input changed by far more than an ulp, and the amplification it is held against."""

    def changes(scene):
        yield "nothing", module.hard_drift.Variant(scene, lambda shape: shape)
        yield "too much", module.hard_drift.Variant(rolled(1.6, elements=4), lambda shape: shape)
        yield "nothing again", module.hard_drift.Variant(scene, lambda shape: shape)

    monkeypatch.setattr(module.hard_drift, "one_ulp", changes)
    monkeypatch.setattr(module.hard_measures, "load_amplification", lambda solution: 8.0)
    result = run_hard_case(QUARTER, full=True)
    found = result.measured["drift, one ulp"]
    assert found > 1e-3
    assert result.notes["drift, one ulp"] == "of the too much"
    assert result.measured["ulp ratio"] == pytest.approx(found / (8.0 * 2.0**-52))
    assert result.verdict is Verdict.FAIL


@pytest.mark.parametrize(("order", "shortfall"), [(1.5, 0.5), (2.5, 0.0), (None, 0.0)])
def test_the_order_falls_short(monkeypatch, one_process, order, shortfall):
    monkeypatch.setattr(module.hard_measures, "observed_orders", lambda solution: (order, order))
    result = run_hard_case(QUARTER)
    assert result.measured["Newton order below 2"] == shortfall
    assert result.measured.get("Newton order") == order
    assert (result.verdict is Verdict.FAIL) is (shortfall > 0.2)


def test_a_walk_that_stops_fails(monkeypatch, one_process):
    monkeypatch.setattr(hard_walk, "walk", lambda scene: [])
    result = run_hard_case(QUARTER)
    assert result.verdict is Verdict.FAIL
    assert result.notes["drift, hundred steps"] == "step 1 of 20 did not converge"


def test_states_that_are_wrong_whatever_their_numbers():
    solution = solve_case(QUARTER, QUARTER.scene)
    fault = module.solution_fault
    assert fault(QUARTER, solution) == ""
    assert "not finite" in fault(QUARTER, replace(solution, q=np.full_like(solution.q, math.nan)))
    unstable = replace(solution, stable=False)
    assert "unstable" in fault(replace(QUARTER, stable=True), unstable)
    silent = replace(solution, stable=False)
    object.__setattr__(silent, "warnings", [])  # a cached property: as if validity.py had said nothing
    assert fault(QUARTER, silent) == "an unstable equilibrium without a warning"
    failed = replace(solution, status=ancf.Status.LIMIT_POINT)
    assert fault(QUARTER, failed) == "limit_point without a reason"
    # r_y -> -r_y at every node mirrors the sections: det F < 0
    q = solution.q.copy().reshape(-1, 3, 3)
    q[:, 1] *= -1.0
    turned = replace(solution, q=q.ravel())
    assert smallest_volume_ratio(turned) < 0.0
    assert "inside out" in fault(QUARTER, turned)


@pytest.fixture
def small_run(monkeypatch, one_process):
    monkeypatch.setattr(module, "hard_cases", lambda: (QUARTER, HUGE))
    return runner.run(parts=("hard cases",))


def test_the_record(small_run):
    data = as_dict(small_run)["hard_cases"]
    assert [entry["name"] for entry in data] == ["quarter", "huge"]
    assert data[0]["verdict"] in ("PASS", "WARN")
    assert len(data[0]["history"]) == data[0]["iterations"]
    assert {check["quantity"] for check in data[0]["checks"]} >= {"deviation", "drift, units"}
    assert data[1]["status"] == "not_finite"
    json.dumps(data, allow_nan=False)


def test_a_journal_gives_a_result_back(small_run):
    result = small_run.hard_cases[0]
    stored = json.loads(json.dumps(keep(result)))
    again = revive(HardResult, stored, {HardCase: QUARTER})
    assert again == result


def test_the_evidence_can_be_judged_again(small_run):
    evidence = evidence_of(small_run)
    for name, result in zip(evidence, small_run.hard_cases, strict=True):
        assert verdict_of(name, evidence[name]) == (result.verdict, [])
        expected = Expectation(hard_limits(result.case, full=False), result.case.expected)
        assert limit_faults(name, evidence[name], expected) == []
    # A wrong ending stays a failure however good the numbers are.
    wrong = replace(small_run.hard_cases[0], fault="ended badly", verdict=Verdict.FAIL)
    entry = evidence_of(replace(small_run, hard_cases=[wrong]))["hard case quarter"]
    assert verdict_of("hard case quarter", entry) == (Verdict.FAIL, [])
    assert verdict_of("hard case quarter", {**entry, "verdict": "PASS"})[1]
