"""Meshes that the program chooses: first meshes, cuts, and shapes carried from one mesh to another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, strategies as st

from ancf.elements import ELEMENTS
from ancf.materials import SaintVenantKirchhoff
from ancf.mesh import rod_breaks
from ancf.model import Model
from ancf.refinement import MOST_PIECES, carried, cut, first_mesh, pieces_for, with_breaks
from ancf.scene import Force, Joint, Place, Rod, Scene, Support
from ancf.sections import Circle
from ancf.segments import Segment

SOFT = SaintVenantKirchhoff(1e6, 0.3)


def plain(element: str = "3333", supports: tuple[Support, ...] = (Support(),), **keys) -> Rod:
    """A rod of two metres without a mesh."""
    return Rod("rod", 2.0, 0, Circle(0.01), SOFT, element, supports=supports, **keys)


def stepped() -> Rod:
    """A rod of three segments, one of them tapered, without a mesh."""
    pieces = (
        Segment(0.5, 0, Circle(0.02), SOFT, Circle(0.01)),
        Segment(1.2, 0, Circle(0.01), SOFT),
        Segment(0.3, 0, Circle(0.005), SOFT),
    )
    return Rod.of_segments("rod", pieces)


def meshed(rod: Rod, accuracy: float = 1e-2, **tables) -> Scene:
    """A scene of one rod with its first mesh."""
    return first_mesh(Scene((rod,), **tables), accuracy)


def test_the_first_mesh_has_a_boundary_everywhere_it_is_needed():
    forces = (Force("rod", 0.33, np.ones(3)), Force("rod", 0.7, np.zeros(3)))
    joints = (Joint("ball", Place("rod", 0.9)),)
    scene = meshed(stepped(), forces=forces, joints=joints)
    breaks = np.array(scene.rods[0].breaks)
    for at in (0.0, 0.25, 0.33, 0.85, 0.9, 1.0):  # supports, ends of segments, load, joint
        assert np.min(np.abs(breaks - at)) < 1e-12
    assert np.min(np.abs(breaks - 0.7)) > 1e-3  # a load of zero moves nothing
    np.testing.assert_allclose(rod_breaks(scene, scene.rods[0]), 2.0 * breaks)


@pytest.mark.parametrize(("accuracy", "count"), [(0.1, 4), (1e-2, 4), (1e-3, 6), (1e-4, 10), (1e-8, 64)])
def test_the_first_mesh_knows_the_accuracy(accuracy, count):
    assert meshed(plain(), accuracy).rods[0].elements == count


def test_elements_of_the_first_mesh_are_short_for_the_curvature():
    rod = meshed(plain(curvature=np.array([0.0, 3.0, 4.0]))).rods[0]  # 10 rad along the rod
    assert rod.elements == 13  # at most pi/4 each


def test_quadratic_sections_have_short_elements_at_a_clamp():
    rod = meshed(plain("3363", (Support(0.0, "clamp"), Support(1.0, "free_section_clamp")))).rods[0]
    lengths = np.diff(rod.breaks)
    assert lengths[0] == pytest.approx(0.5 * 0.01 / 2.0)  # half a radius
    np.testing.assert_allclose(lengths[1:4] / lengths[:3], [1.0, 2.0, 2.0])  # growing from there
    assert lengths[-1] == pytest.approx(0.25)
    middle = meshed(plain("3363", (Support(0.5, "clamp"),))).rods[0]
    np.testing.assert_allclose(np.diff(middle.breaks), np.diff(middle.breaks)[::-1])
    assert np.diff(middle.breaks).min() == pytest.approx(0.0025)


@given(st.lists(st.integers(1, 5), min_size=1, max_size=6))
def test_a_cut_keeps_every_boundary(pieces):
    rod = with_breaks(plain(), np.linspace(0.0, 1.0, len(pieces) + 1))
    finer = cut(rod, np.array(pieces))
    assert finer.elements == sum(pieces) == len(finer.breaks) - 1
    assert set(rod.breaks) <= set(finer.breaks)
    assert np.all(np.diff(finer.breaks) > 0.0)
    lengths = np.split(np.diff(finer.breaks), np.cumsum(pieces)[:-1])
    for own in lengths:
        np.testing.assert_allclose(own, own[0])


def test_a_cut_counts_the_elements_of_each_segment():
    rod = meshed(stepped()).rods[0]
    finer = cut(rod, 3)
    assert [s.elements for s in finer.segments] == [3 * s.elements for s in rod.segments]


def test_breaks_and_elements_must_agree():
    with pytest.raises(ValueError, match="3 breaks and 4 elements"):
        replace(plain(), elements=4, breaks=(0.0, 0.5, 1.0))


@given(st.lists(st.floats(1e-6, 1.0), min_size=1, max_size=20), st.floats(0.005, 0.9))
@example([1.0, 0.078125], 0.125)  # rounded by themselves 3 and 2 pieces, where 2 and 2 do
def test_pieces_reach_the_reduction_at_little_cost(contributions, reduction):
    eta = np.array(contributions)
    pieces = pieces_for(eta, reduction, 4)
    left = float(eta @ pieces**-4.0)
    assert np.all((pieces >= 1) & (pieces <= MOST_PIECES))
    assert left <= reduction * eta.sum() * (1 + 1e-12)
    uniform = int(np.ceil(reduction**-0.25))
    assert pieces.sum() <= uniform * len(eta)


def test_equal_contributions_are_cut_alike_and_small_ones_not():
    assert pieces_for(np.ones(5), 0.9, 4).tolist() == [2] * 5
    assert pieces_for(np.ones(5), 1.0 / 81.0, 4).tolist() == [3] * 5
    assert pieces_for(np.array([1.0, 1e-6]), 0.1, 4).tolist() == [2, 1]
    assert pieces_for(np.ones(3), 1e-9, 4).tolist() == [MOST_PIECES] * 3  # as far as one round goes


@pytest.mark.parametrize("element", ELEMENTS)
def test_a_shape_carried_to_a_nested_mesh_is_the_same(element):
    scene = meshed(replace(plain(element), formulation=""))
    finer = replace(scene, rods=(cut(scene.rods[0], np.arange(scene.rods[0].elements) % 3 + 1),))
    coarse, fine = Model(scene), Model(finer)
    rng = np.random.default_rng(3)
    q = coarse.q0 + rng.normal(size=coarse.n)
    there = carried(coarse, q, fine)
    for at in (0.0, 0.13, 0.5, 0.77, 1.0):
        points = [model.rods[0].section_point(at) for model in (coarse, fine)]
        shapes = [p.N @ v[p.dofs].reshape(-1, 3) for p, v in zip(points, (q, there), strict=True)]
        np.testing.assert_allclose(shapes[1], shapes[0], atol=1e-11)
    np.testing.assert_allclose(carried(coarse, coarse.q0, fine), fine.q0, atol=1e-12)
