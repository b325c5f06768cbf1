"""Machine-independent numbers of `ancf cost` stay within `cost_limits.toml`: our own earlier numbers."""

import tomllib
from pathlib import Path

import pytest

from ancf.elements import ELEMENTS
from validation.cost.families import families
from validation.cost.points import beam_point
from validation.cost.run import settings

LIMITS = tomllib.loads(Path(__file__).with_name("cost_limits.toml").read_text())["family"]
FAMILIES = {family.name: family for family in families()}


def test_every_family_has_limits_and_reasons():
    assert [entry["name"] for entry in LIMITS] == list(FAMILIES)
    for entry in LIMITS:
        assert entry["reason"]
        assert {"3333", "3243"} <= {limit["element"] for limit in entry["limits"]}


@pytest.mark.parametrize("entry", LIMITS, ids=[entry["name"] for entry in LIMITS])
def test_errors_iterations_and_unknowns(entry):
    family = FAMILIES[entry["name"]]
    reference = family.find_reference(family.scene)
    for limit in entry["limits"]:
        rod = next(
            s.rod
            for s in settings(ELEMENTS[limit["element"]], family, False)
            if s.formulation == limit["setting"] and not s.solver
        )
        point, solution = beam_point(family.with_rod(elements=limit["elements"], **rod), 1)
        assert point.converged, point.status
        assert solution is not None
        assert point.unknowns == limit["unknowns"], limit
        assert point.iterations <= limit["iterations"], limit
        assert family.error(solution.tip().position, reference) <= limit["error"], limit


@pytest.mark.parametrize("name", ["helix", "tip force", "gravity", "45-degree bend"])
def test_a_reference_is_better_than_what_it_judges(name):
    """A third of the smallest limit at most, the rule of validation/criteria.py."""
    family = FAMILIES[name]
    smallest = min(k["error"] for entry in LIMITS if entry["name"] == name for k in entry["limits"])
    assert 3.0 * family.find_reference(family.scene).error < smallest
