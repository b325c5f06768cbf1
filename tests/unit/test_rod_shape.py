"""Local measures and back."""

import numpy as np
import pytest
from hypothesis import given

from ancf.elements import ELEMENTS, SECTION_ELEMENTS
from ancf.rod_shape import from_local, node_rotations, to_local
from tests.strategies import draws
from validation.random_rods import (
    RodRange,
    bent_state,
    random_model,
    random_rotation,
    random_state,
    random_vector,
)

FINE = RodRange(elements=(2, 3, 5), slenderness=(8.0, 60.0))


@pytest.mark.parametrize("name", ELEMENTS)
@given(source=draws())
def test_there_and_back(name, source):
    """from_local(to_local(q)) = q from every node."""
    model = random_model(source, name, FINE)
    q = random_state(source, model)
    shape, rotations = to_local(model, q), node_rotations(model, q)
    for node in (0, len(q) // 2, len(q) - 1):
        back = from_local(model, shape, node, q[node, 0], rotations[node])
        np.testing.assert_allclose(back, q, atol=1e-12 * max(1.0, model.rod.length))


@pytest.mark.parametrize("name", SECTION_ELEMENTS)
@given(source=draws())
def test_measures_do_not_see_rigid_motions(name, source):
    model = random_model(source, name, FINE)
    q, R = random_state(source, model), random_rotation(source)
    moved = q @ R.T
    moved[:, 0] += random_vector(source, model.rod.length)
    a, b = to_local(model, q), to_local(model, moved)
    np.testing.assert_allclose(a.theta, b.theta, atol=1e-12)
    np.testing.assert_allclose(a.chord, b.chord, atol=1e-12 * model.rod.length)
    np.testing.assert_allclose(a.vectors, b.vectors, atol=1e-12)


@pytest.mark.parametrize("name", SECTION_ELEMENTS)
@given(source=draws())
def test_a_turned_section_has_its_turn(name, source):
    """A straight rod whose sections turn by x/L v: theta between nodes is v times their distance over L."""
    model = random_model(source, name, RodRange(elements=(3, 5), curved=(False,)))
    v = random_vector(source, 1.5)
    shape = to_local(model, bent_state(model, v))
    steps = np.diff(model.mesh.node_x) / model.rod.length
    # theta is taken in section axes of the first node of each pair, about which v itself does not turn
    np.testing.assert_allclose(shape.theta, steps[:, None] * v, atol=1e-12)


def test_shapes_add_and_scale():
    model = random_model_of_three()
    a, b = to_local(model, bent_state(model, np.array([0.1, 0.2, 0.3]))), to_local(model, model.q0)
    total = a + b * -2.0
    np.testing.assert_array_equal(total.theta, a.theta - 2.0 * b.theta)
    np.testing.assert_array_equal(total.chord, a.chord - 2.0 * b.chord)
    np.testing.assert_array_equal(total.vectors, a.vectors - 2.0 * b.vectors)


def random_model_of_three():
    from validation.random_rods import RngDraws

    return random_model(RngDraws(np.random.default_rng(0)), "3243", RodRange(elements=(3,)))
