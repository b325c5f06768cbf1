"""Every property of validation/properties.py on every element, its examples drawn by Hypothesis."""

import numpy as np
import pytest
from hypothesis import given, note, settings

from tests.strategies import draws, fewer
from validation.properties import PROPERTIES

EACH = [
    pytest.param(prop, element, id=f"{prop.name}-{element}")
    for prop in PROPERTIES
    for element in prop.element_names
]
KERNEL = [case for case in EACH if not case.values[0].solves]
SOLVED = [case for case in EACH if case.values[0].solves]


@pytest.mark.parametrize(("prop", "element"), KERNEL)
@given(source=draws())
def test_kernel_property(prop, element, source):
    observed = prop.observe(source, element)
    note(f"{prop.title}: {observed:.3g} {prop.unit}, bound {prop.bound:g} ({prop.source})")
    assert observed <= prop.bound


@pytest.mark.parametrize(("prop", "element"), SOLVED)
@settings(max_examples=fewer(2))
@given(source=draws())
def test_solution_property(prop, element, source):
    observed = prop.observe(source, element)
    note(f"{prop.title}: {observed:.3g} {prop.unit}, bound {prop.bound:g} ({prop.source})")
    assert observed <= prop.bound


def test_every_property_runs_as_the_report_runs_it():
    """The report draws with NumPy: two examples each, same bounds."""
    names = [prop.name for prop in PROPERTIES]
    assert len(set(names)) == len(names)
    for index, prop in enumerate(PROPERTIES):
        rng = np.random.default_rng(index)
        assert np.isfinite(prop.run(rng))
