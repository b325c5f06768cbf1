"""Every property of validation/properties.py on every element, its examples drawn by Hypothesis."""

import numpy as np
import pytest
from hypothesis import given, note, settings

from ancf.elements import ELEMENTS
from tests.strategies import ListedDraws, draws, fewer
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


def check(prop, element, source):
    """One example; a failing one prints what to keep in `KEPT`."""
    try:
        observed = prop.observe(source, element)
    finally:
        note(f"drawn: {source.drawn}")
    note(f"{prop.title}: {observed:.3g} {prop.unit}, bound {prop.bound:g} ({prop.source})")
    assert observed <= prop.bound


@pytest.mark.parametrize(("prop", "element"), KERNEL)
@given(source=draws())
def test_kernel_property(prop, element, source):
    check(prop, element, source)


@pytest.mark.parametrize(("prop", "element"), SOLVED)
@settings(max_examples=fewer(2))
@given(source=draws())
def test_solution_property(prop, element, source):
    check(prop, element, source)


@pytest.mark.parametrize(("prop", "element"), SOLVED_QUADRATIC)
@settings(max_examples=fewer(8))
@given(source=draws())
def test_solution_property_of_quadratic_sections(prop, element, source):
    check(prop, element, source)


# Counterexamples of Hypothesis as they were drawn: `@example` cannot give one of many properties its own.
SAINT_VENANT, NEO_HOOKEAN = "saint-venant-kirchhoff", "neo-hookean"
ORIGIN = (0.0, 0.0, 0.0)
UNTURNED = (0.0, 0.0, 0.0, 0.0)  # a quaternion, not normalised; zero is no rotation
KEPT = [
    # Two elements of 0.89 L and 0.11 L: the floor is that of the shorter one, not that of two equal ones.
    ("rigid-floor", "3363", (
        -1.5, 8.0, "circle", 0.5, 2, False, "enhanced", SAINT_VENANT, 0.0, 4.0, 500.0, "default",
        *ORIGIN, 0.125, -1.0, 0.0, 0.25, "clamp", True, 0.8922990465225935,
        1.0, 0.9609375, 0.75, 0.25, *ORIGIN)),
    # One element turned by 1 rad, nu = 0.496: D of the strained rubber has negative diagonal terms.
    ("zero-modes-bent", "3363", (
        -2.0, 8.0, "circle", 0.5, 1, False, "enhanced", NEO_HOOKEAN, 0.49609375, 4.0, 500.0, "default",
        *ORIGIN, *UNTURNED, "clamp", False, 0.0, 0.0, 1.0, *UNTURNED)),
    # The direction of the differences was 0.0025 of the state: rounding made 1/6 of the error at one step.
    ("load-order", "3333", (
        0.0, 8.0, "annulus", 0.5, 1, False, "enhanced", False, SAINT_VENANT, 0.0, 4.0, 500.0, "default",
        *ORIGIN, 0.5, 0.0, -0.25, -0.125, "clamp", 0.5, 0.0, *ORIGIN, "fixed", *ORIGIN,
        *ORIGIN, 0, -1.0, 0.0, 0.0, 1.0, *ORIGIN, 0, *UNTURNED)),
    # The power of a small change is 1/1500 of its terms, and the steps are 2.5e-4 of the vectors: rounding.
    ("elastic-derivative", "3243", (
        0.0, 8.0, "circle", 0.5, 1, False, "enhanced", False, NEO_HOOKEAN, 0.0, 4.0, 500.0, "default",
        *ORIGIN, 1.0, 0.0, 1.0, -1.0, "clamp", False, -2.0, 1.0, -2.0, 0, *UNTURNED, *ORIGIN, 0, *UNTURNED)),
    # A 2-node element turned by 3 rad had det F = 0.006: rubber differenced where no section is left.
    ("elastic-derivative", "3243", (
        0.0, 8.0, "circle", 0.5, 1, False, "enhanced", False, NEO_HOOKEAN, 0.0, 4.0, 500.0, "default",
        *ORIGIN, 1.0, 0.0, 1.0, -1.0, "clamp", False, 1.0, 2.0, 2.0, 0, 0.0, 0.0, 1.0, 0.0, *ORIGIN, 0,
        *UNTURNED)),
    # nu = -0.5: besides the lateral stretch 0.92 a second, unstable one of 0.51.
    ("stretch", "3333", (
        0.0, 5.0, "circle", 0.5, 1, False, "enhanced", False, NEO_HOOKEAN, -0.5, 4.0, 500.0, "default",
        *ORIGIN, *UNTURNED, "free_section_clamp", 0.875)),
    # A moment alone was solved in space, with a force of value zero beside it in the plane.
    ("zero-effects", "3333", (
        0.0, 15.0, "circle", 0.5, 4, False, "enhanced", False, SAINT_VENANT, 0.0, 4.0, 500.0, "default",
        *ORIGIN, *UNTURNED, "clamp", 1, "moment", 1.0, 0.0, 0.0, 0.0625)),
]  # fmt: skip


@pytest.mark.parametrize(("name", "element", "drawn"), KEPT)
def test_counterexamples_that_were_kept(name, element, drawn):
    (prop,) = [prop for prop in PROPERTIES if prop.name == name]
    source = ListedDraws(drawn)
    assert prop.observe(source, element) <= prop.bound
    assert not source.left


SEEDS = [
    # det F = 0.1 in Mooney-Rivlin rubber, a 2-node element turned by 2.8 rad; `LARGEST_BEND` makes it 2.5.
    ("elastic-derivative", (8611, 8, 101)),
    # Two elements of 0.9 L and 0.1 L, as above; 2.7 times the floor of equal elements.
    ("rigid-floor", (1, 2053)),
]


@pytest.mark.parametrize(("name", "seed"), SEEDS, ids=[name for name, _ in SEEDS])
def test_examples_that_once_failed(name, seed):
    (prop,) = [prop for prop in PROPERTIES if prop.name == name]
    assert prop.run(np.random.default_rng(seed)) <= prop.bound


def test_every_property_runs_as_the_report_runs_it():
    """The report draws with NumPy: two examples each, same bounds."""
    names = [prop.name for prop in PROPERTIES]
    assert len(set(names)) == len(names)
    for index, prop in enumerate(PROPERTIES):
        rng = np.random.default_rng(index)
        assert np.isfinite(prop.run(rng))
