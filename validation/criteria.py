"""Verdicts: what a number found is worth against its limit, and what many verdicts are worth together.

A margin is limit / observed. PASS from 1.5, WARN below 1.5, FAIL below 1. If the reference may itself be
wrong by more
than a third of the limit, nothing can be concluded. An expected miss has to miss by the documented amount.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable
from dataclasses import dataclass

WARN_MARGIN = 1.5
REFERENCE_SHARE = 1.0 / 3.0  # of the limit: the largest error the reference itself may have


class Verdict(enum.StrEnum):
    """What one check, one case or the whole run is worth."""

    PASS = "PASS"
    WARN = "WARN"
    FAIL = "FAIL"
    KNOWN_LIMIT = "KNOWN LIMIT"
    INCONCLUSIVE = "INCONCLUSIVE"


BLOCKING = (Verdict.FAIL, Verdict.INCONCLUSIVE)
# Worst first: the verdict of a case is the worst of its checks.
SEVERITY = (Verdict.FAIL, Verdict.INCONCLUSIVE, Verdict.WARN, Verdict.KNOWN_LIMIT, Verdict.PASS)


@dataclass(frozen=True)
class Limit:
    """The largest deviation that is accepted for a quantity, and why.

    Parameters
    ----------
    quantity : name of the deviation; may hold wildcards when one limit serves several
    value : limit, in `unit`
    reason : why a correct program meets this and no looser number is wanted
    kind : ``reference`` (analytic, other code) or ``non-regression`` (our own earlier number, a count)
    documented : expected deviation of a known limit, None for a limit that has to be met
    spread : accepted relative distance from `documented`
    """

    quantity: str
    value: float
    unit: str
    reason: str
    kind: str = "reference"
    documented: float | None = None
    spread: float = 0.05


@dataclass(frozen=True)
class Finding:
    """One check: what was found against its limit."""

    quantity: str
    limit: Limit
    observed: float | None
    reference_error: float
    verdict: Verdict
    margin: float | None
    note: str = ""


def judge(limit: Limit, quantity: str, observed: float, reference_error: float = 0.0) -> Finding:
    """Verdict of one deviation.

    Parameters
    ----------
    observed : deviation from the reference, >= 0, in the unit of the limit
    reference_error : estimated error of the reference itself, same unit; infinite where it has no answer

    Returns
    -------
    Finding; margin = limit / observed, None where that is not finite (an exact hit).
    """

    def finding(verdict: Verdict, note: str = "") -> Finding:
        finite = math.isfinite(observed)
        margin = limit.value / abs(observed) if finite and observed != 0.0 else None
        if margin is not None and not math.isfinite(margin):
            margin = None
        return Finding(quantity, limit, observed if finite else None, reference_error, verdict, margin, note)

    if not math.isfinite(reference_error):
        return finding(Verdict.INCONCLUSIVE, "the reference has no answer here")
    if not math.isfinite(observed):
        return finding(Verdict.FAIL, "not a finite number")
    if reference_error > REFERENCE_SHARE * limit.value * (1 + 1e-9):
        return finding(
            Verdict.INCONCLUSIVE,
            f"the reference may err by {reference_error:.1e}, more than a third of the limit",
        )
    size = abs(observed)
    if limit.documented is not None:
        expected = abs(limit.documented)
        if size <= limit.value:
            return finding(Verdict.FAIL, f"expected to miss by {expected:.4g}, but it met the limit")
        if abs(size - expected) > limit.spread * expected:
            return finding(Verdict.FAIL, f"missed by {size:.4g}, documented is {expected:.4g}")
        return finding(Verdict.KNOWN_LIMIT, f"documented miss {expected:.4g}")
    if size > limit.value:
        return finding(Verdict.FAIL)
    # A count of iterations is a whole number near its limit by nature: it is met or not.
    if limit.kind == "reference" and size * WARN_MARGIN > limit.value * (1 + 1e-9):
        return finding(Verdict.WARN, "close to the limit")
    return finding(Verdict.PASS)


def largest(*values: float) -> float:
    """The largest value; infinite when there is none or one is no number, which Python's max forgets."""
    return max((math.inf if math.isnan(value) else float(value) for value in values), default=math.inf)


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """The worst verdict; nothing checked is a failure."""
    found = set(verdicts)
    for verdict in SEVERITY:
        if verdict in found:
            return verdict
    return Verdict.FAIL


def overall(required: Iterable[Verdict], cases_run: int, skipped: Iterable[str]) -> tuple[Verdict, list[str]]:
    """Verdict of a run and the reasons it is not PASS.

    Parameters
    ----------
    required : verdicts of everything that has to hold
    cases_run : number of cases that were really run; none is a failure
    skipped : names of required cases that were not run; each is a failure

    Returns
    -------
    PASS or FAIL, and the reasons. Warnings and known limits do not fail a run.
    """
    reasons = [f"required case {name} was not run" for name in skipped]
    if cases_run == 0:
        reasons.append("no case was run")
    verdicts = list(required)
    reasons += [f"{verdicts.count(v)} required results: {v}" for v in BLOCKING if v in verdicts]
    return (Verdict.FAIL if reasons else Verdict.PASS), reasons
