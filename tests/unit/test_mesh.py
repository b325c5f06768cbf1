"""Mesh and reference configuration."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.integrate import solve_ivp

from ancf.elements import ELEMENTS
from ancf.materials import SaintVenantKirchhoff
from ancf.mesh import element_breaks, make_mesh, reference_axis, reference_nodes, rod_breaks
from ancf.rotation import hat
from ancf.scene import Force, Frame, Moment, Rod, Scene, Support
from ancf.sections import Circle
from tests.strategies import rotations, vectors


@given(st.lists(st.integers(1, 999).map(lambda i: i / 1000), max_size=4), st.integers(1, 40))
def test_every_anchor_is_a_boundary_and_every_element_is_used(anchors, elements):
    elements = max(elements, len({0.0, 1.0, *anchors}) - 1)  # as many as pieces at least
    breaks = element_breaks(2.0, elements, anchors)
    assert len(breaks) == elements + 1
    assert np.all(np.diff(breaks) > 0)
    for mark in (0.0, 1.0, *anchors):
        assert np.min(np.abs(breaks - 2.0 * mark)) < 1e-12


def rod_and_loads(elements, supports, loads):
    rod = Rod(
        "rod",
        2.0,
        elements,
        Circle(0.01),
        SaintVenantKirchhoff(1.0, 0.0),
        supports=tuple(map(Support, supports)),
    )
    moments = tuple(Moment("rod", at, np.array([0.0, size, 0.0])) for at, size in loads)
    return rod, Scene((rod,), moments=moments, forces=(Force("other", 0.77, np.ones(3)),))


def test_loads_stand_on_boundaries_while_elements_last():
    """Supports always; loads of this rod if there are elements for all; loads of zero magnitude never."""
    rod, scene = rod_and_loads(3, [0.0], [(0.3, 1.0), (0.9, 0.0)])
    np.testing.assert_allclose(rod_breaks(scene, rod), [0.0, 0.6, 1.3, 2.0])
    rod, scene = rod_and_loads(2, [0.0, 0.4], [(0.3, 1.0)])
    np.testing.assert_allclose(rod_breaks(scene, rod), [0.0, 0.8, 2.0])
    rod, scene = rod_and_loads(4, [0.0], [(0.3, 0.0)])
    np.testing.assert_allclose(rod_breaks(scene, rod), [0.0, 0.5, 1.0, 1.5, 2.0])


def test_anchors_on_the_uniform_grid_leave_it_uniform():
    np.testing.assert_allclose(
        element_breaks(3.0, 12, [0.25, 0.5, 1.0, 0.0]), np.linspace(0, 3, 13), atol=1e-15
    )


def test_elements_are_shared_out_in_proportion():
    """Largest remainder: 10 elements over .3 and .7 are 3 and 7; 4 over .1 and .9 are 1 and 3."""
    np.testing.assert_allclose(np.diff(element_breaks(1.0, 10, [0.3])), 0.1)
    np.testing.assert_allclose(np.diff(element_breaks(1.0, 4, [0.1])), [0.1, 0.3, 0.3, 0.3])


@pytest.mark.parametrize("name", ELEMENTS)
def test_neighbours_share_a_node(name):
    mesh = make_mesh(ELEMENTS[name], np.array([0.0, 1.0, 1.5, 3.0]))
    assert np.all(mesh.nodes_of[1:, 0] == mesh.nodes_of[:-1, -1])
    np.testing.assert_allclose(mesh.node_x[mesh.nodes_of[:, 0]], [0.0, 1.0, 1.5])
    np.testing.assert_allclose(mesh.node_x[mesh.nodes_of[:, -1]], [1.0, 1.5, 3.0])
    assert set(mesh.nodes_of.ravel()) == set(range(len(mesh.node_x)))
    middle = mesh.node_x[mesh.nodes_of] - mesh.node_x[mesh.nodes_of[:, :1]]
    np.testing.assert_allclose(
        middle, mesh.h[:, None] * (1 + np.array(ELEMENTS[name].node_xi)) / 2, atol=1e-15
    )


@pytest.mark.parametrize(
    "k", [(0, 0, 0), (0, 0, 0.01), (0.3, -2.0, 1.0), (5.0, 0, 0), (1e-4, 1e-4, 0), (9e-4, 0, 9e-4)]
)
def test_reference_axis_integrates_the_curvature(k):
    """R' = R hat(k), r' = R e_x by SciPy's DOP853 to 1e-13."""
    k = np.array(k, float)

    def slope(x, state):
        R = state[3:].reshape(3, 3)
        return np.concatenate([R[:, 0], (R @ hat(k)).ravel()])

    x = np.array([0.0, 0.4, 1.0, 2.0])
    start = np.concatenate([np.zeros(3), np.eye(3).ravel()])
    state = solve_ivp(slope, (0, 2), start, "DOP853", x, rtol=1e-13, atol=1e-14).y.T
    position, frame = reference_axis(x, k)
    np.testing.assert_allclose(position, state[:, :3], atol=1e-12)
    np.testing.assert_allclose(frame, state[:, 3:].reshape(-1, 3, 3), atol=1e-12)


def test_an_arc_bends_as_the_interface_says():
    """interface.md: curvature [0, 0, 0.01] is an arc of radius 100 from the base along x bending to +y."""
    x = 100 * np.pi / 4
    position, frame = reference_axis(np.array([x]), np.array([0.0, 0.0, 0.01]))
    np.testing.assert_allclose(
        position[0], 100 * np.array([np.sin(np.pi / 4), 1 - np.cos(np.pi / 4), 0]), rtol=1e-13
    )
    np.testing.assert_allclose(frame[0][:, 0], [np.sqrt(0.5), np.sqrt(0.5), 0], atol=1e-14)


@pytest.mark.parametrize("name", ELEMENTS)
@given(rotations(), vectors(0.5))
def test_reference_vectors_are_the_columns_of_the_turned_frame(name, A_o, k):
    """Paper eq. 1-6 as corrected in paper-map.md: a gradient column maps as A_o applied to the vector."""
    rod = Rod(
        "rod", 2.0, 3, Circle(0.01), SaintVenantKirchhoff(1.0, 0.0), base=Frame(np.ones(3), A_o), curvature=k
    )
    x = np.linspace(0, 2, 5)
    q = reference_nodes(rod, ELEMENTS[name], x)
    position, frame = reference_axis(x, k)
    for v, order in enumerate(ELEMENTS[name].vectors):
        for n in range(5):
            if sum(order) > 1:
                expected = np.zeros(3)  # the reference section is plane
            else:
                expected = position[n] if sum(order) == 0 else frame[n] @ np.eye(3)[order.index(1)]
            np.testing.assert_allclose(q[n, v], A_o @ expected, atol=1e-14)
