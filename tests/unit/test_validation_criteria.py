"""Verdicts: thresholds 1.5 and 1 on the margin, a third of the limit for the reference (architecture,
"Validation practice")."""

from __future__ import annotations

import math

import pytest

from validation.criteria import Limit, Verdict, judge, overall, worst


def limit(**changes) -> Limit:
    return Limit(**{"quantity": "tip", "value": 3e-3, "unit": "L", "reason": "because", **changes})


@pytest.mark.parametrize(
    ("observed", "verdict"),
    [
        (0.0, Verdict.PASS),
        (1.9e-3, Verdict.PASS),  # margin 1.58
        (2.0e-3, Verdict.PASS),  # margin 1.5 exactly
        (2.1e-3, Verdict.WARN),  # margin 1.43
        (3.0e-3, Verdict.WARN),  # margin 1
        (3.1e-3, Verdict.FAIL),
        (-3.1e-3, Verdict.FAIL),  # a deviation's sign does not excuse it
    ],
)
def test_margin_decides(observed, verdict):
    assert judge(limit(), "tip", observed).verdict is verdict


def test_margin_is_limit_over_observed():
    assert judge(limit(), "tip", 1e-3).margin == pytest.approx(3.0)
    assert judge(limit(), "tip", 0.0).margin is None


@pytest.mark.parametrize("observed", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_fails_and_is_not_stored(observed):
    finding = judge(limit(), "tip", observed)
    assert finding.verdict is Verdict.FAIL
    assert finding.observed is None
    assert finding.margin is None


@pytest.mark.parametrize("observed", [0.0, 1e-5, 1.0])
def test_an_uncertain_reference_concludes_nothing(observed):
    assert judge(limit(), "tip", observed, reference_error=1.01e-3).verdict is Verdict.INCONCLUSIVE
    assert judge(limit(), "tip", observed, reference_error=math.nan).verdict is Verdict.INCONCLUSIVE
    assert judge(limit(), "tip", observed, reference_error=0.99e-3).verdict is not Verdict.INCONCLUSIVE


@pytest.mark.parametrize(
    ("observed", "verdict"),
    [
        (0.1856, Verdict.KNOWN_LIMIT),
        (0.1849, Verdict.KNOWN_LIMIT),  # within 1 % of the documented miss
        (0.17, Verdict.FAIL),  # misses by another amount
        (1e-4, Verdict.FAIL),  # no longer misses: the documentation is wrong
    ],
)
def test_a_known_limit_has_to_miss_by_its_documented_amount(observed, verdict):
    assert judge(limit(documented=0.1856, spread=0.01), "tip", observed).verdict is verdict


def test_counts_of_our_own_have_no_margin():
    count = limit(value=5, kind="non-regression")
    assert judge(count, "iterations", 5).verdict is Verdict.PASS
    assert judge(count, "iterations", 6).verdict is Verdict.FAIL


def test_the_worst_verdict_counts():
    assert worst([Verdict.PASS, Verdict.WARN, Verdict.KNOWN_LIMIT]) is Verdict.WARN
    assert worst([Verdict.PASS, Verdict.INCONCLUSIVE, Verdict.WARN]) is Verdict.INCONCLUSIVE
    assert worst([Verdict.INCONCLUSIVE, Verdict.FAIL]) is Verdict.FAIL
    assert worst([Verdict.PASS, Verdict.KNOWN_LIMIT]) is Verdict.KNOWN_LIMIT
    assert worst([]) is Verdict.FAIL  # nothing compared


def test_warnings_and_known_limits_do_not_fail_a_run():
    assert overall([Verdict.PASS, Verdict.WARN, Verdict.KNOWN_LIMIT], 3, []) == (Verdict.PASS, [])


@pytest.mark.parametrize("verdict", [Verdict.FAIL, Verdict.INCONCLUSIVE])
def test_one_blocking_verdict_fails_a_run(verdict):
    found, reasons = overall([Verdict.PASS, verdict], 2, [])
    assert found is Verdict.FAIL
    assert reasons == [f"1 required results: {verdict}"]


def test_a_run_without_cases_fails():
    assert overall([], 0, []) == (Verdict.FAIL, ["no case was run"])


def test_a_skipped_required_case_fails_a_run():
    assert overall([Verdict.PASS], 1, ["HX"]) == (Verdict.FAIL, ["required case HX was not run"])
