"""What a full run of the present code has to show: every required check by name, with its limits."""

from __future__ import annotations

import glob
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from validation.cases import Case
from validation.criteria import Limit


@dataclass(frozen=True)
class Expectation:
    """Limits that a check is held against (name patterns allowed), and statuses it may end in."""

    limits: tuple[Limit, ...]
    statuses: tuple[str, ...] = ()


def expected_checks(cases: Iterable[Case], full: bool = True) -> dict[str, Expectation]:
    """Required checks of a run by the names that `Run.checks` gives them.

    Parameters
    ----------
    cases : the cases of the run
    full : whether the studies are those of a full run
    """
    from validation import convergence, hard_cases, runner
    from validation.hard_limits import hard_limits
    from validation.properties import PROPERTIES

    found = {f"case {case.id}": Expectation(case.limits) for case in cases if case.required}
    for study in convergence.studies(full):
        order = Limit("order below its promise", convergence.SHORTFALL, "-", study.why)
        bound = Limit(f"error with {study.meshes[-1]} elements", study.finest, "L or rad", study.why)
        found[f"order {study.name} {study.element}"] = Expectation((order, bound))
    found |= {f"reference {name}": expectation for name, expectation in _reference_checks(full).items()}
    for check in PROPERTIES:
        limit = Limit(check.name, check.bound, check.unit, check.title)
        found[f"property {check.name}"] = Expectation((limit,))
    for case in hard_cases.hard_cases():
        found[f"hard case {case.name}"] = Expectation(hard_limits(case, full), case.expected)
    return found | {name: Expectation((limit,)) for name, limit in runner.STUDIES.items()}


def _reference_checks(full: bool) -> dict[str, Expectation]:
    """Checks of the reference itself, without those that only some machines can make."""
    from validation.reference_checks import SHORTFALL, checks  # scikit-fem

    found = {}
    for check in checks(full):
        if check.optional:
            continue
        name = glob.escape(check.name)
        bounds = check.bound if isinstance(check.bound, Mapping) else {"*": check.bound}
        orders = [
            Limit(f"{name}: order of {glob.escape(of)} below its promise", SHORTFALL, "-", check.reason)
            for of in check.promised
        ]
        errors = [Limit(f"{name}: {of}", bound, "-", check.reason) for of, bound in bounds.items()]
        found[check.name] = Expectation((*orders, *errors))
    return found
