"""Every property of validation/properties.py on every element, its examples drawn by Hypothesis."""

import numpy as np
import pytest
from hypothesis import given, note, settings

from ancf.elements import ELEMENTS
from tests.strategies import draws, fewer
from validation.properties import PROPERTIES


def quadratic(case) -> bool:
    """Whether sections are quadratic: rubber by quadrature on twice the unknowns makes solves dear."""
    return ELEMENTS[case.values[1]].quadratic_section


EACH = [
    pytest.param(prop, element, id=f"{prop.name}-{element}")
    for prop in PROPERTIES
    for element in prop.element_names
]
KERNEL = [case for case in EACH if not case.values[0].solves]
SOLVED = [case for case in EACH if case.values[0].solves and not quadratic(case)]
SOLVED_QUADRATIC = [case for case in EACH if case.values[0].solves and quadratic(case)]


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


@pytest.mark.parametrize(("prop", "element"), SOLVED_QUADRATIC)
@settings(max_examples=fewer(8))
@given(source=draws())
def test_solution_property_of_quadratic_sections(prop, element, source):
    observed = prop.observe(source, element)
    note(f"{prop.title}: {observed:.3g} {prop.unit}, bound {prop.bound:g} ({prop.source})")
    assert observed <= prop.bound


@pytest.mark.parametrize(("name", "seed"), [("elastic-derivative", (8611, 8, 101))])
def test_examples_that_once_failed(name, seed):
    """det F = 0.1 in Mooney-Rivlin rubber: differences need shorter steps there."""
    (prop,) = [prop for prop in PROPERTIES if prop.name == name]
    assert prop.run(np.random.default_rng(seed)) <= prop.bound


def test_every_property_runs_as_the_report_runs_it():
    """The report draws with NumPy: two examples each, same bounds."""
    names = [prop.name for prop in PROPERTIES]
    assert len(set(names)) == len(names)
    for index, prop in enumerate(PROPERTIES):
        rng = np.random.default_rng(index)
        assert np.isfinite(prop.run(rng))
