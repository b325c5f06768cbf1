"""What the three-dimensional pictures draw: arrows, plates, tendons, chambers, and the fields on the skin."""

import math

import numpy as np
import pytest

import ancf

pytest.importorskip("pyvista", reason="three-dimensional pictures need the extra [pictures]")

from ancf import view_marks as vm
from ancf.view_3d import _outlook
from ancf.view_skin import FIELD, FIELDS, box, skins, telling_field

SIZE = 1.0
ROD = {
    "name": "arm", "length": 1.0, "elements": 8, "section": {"shape": "circle", "radius": 0.02},
    "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1.0},
}  # fmt: skip
EI = 1e6 * math.pi * 0.02**4 / 4


def solved(rod=None, **effects):
    solution = ancf.solve(ancf.scene_from_dict({"rod": [{**ROD, **(rod or {})}], **effects}))
    assert solution.status == "converged"
    return solution


def drawn(solution, colour):
    return [mark.mesh for mark in vm.marks(solution, SIZE) if mark.colour == colour]


def test_a_pull_starts_at_its_place_and_a_push_ends_there():
    tiny = 1e-9  # N: the rod stays straight, its tip at (1, 0, 0)
    (pull,) = drawn(solved(force=[{"value": [tiny, 0, 0]}]), vm.LOAD)
    (push,) = drawn(solved(force=[{"value": [-tiny, 0, 0]}]), vm.LOAD)
    for arrow, widest_at in ((pull, 1.0 + 0.68 * vm.ARROW), (push, 1.0 + 0.32 * vm.ARROW)):
        assert arrow.bounds[0] == pytest.approx(1.0, abs=1e-5)
        assert arrow.bounds[1] == pytest.approx(1.0 + vm.ARROW, abs=1e-5)
        widest = arrow.points[np.argmax(np.hypot(*arrow.points[:, 1:].T))]
        assert widest[0] == pytest.approx(
            widest_at, abs=1e-5
        )  # where the head begins: it points along the force


def test_smaller_loads_have_shorter_arrows_and_zero_has_none():
    forces = [{"value": [0, 0, v]} for v in (1e-9, 6e-10, 1e-12, 0.0)]
    heights = [m.bounds[5] - m.bounds[4] for m in drawn(solved(force=forces), vm.LOAD)]
    np.testing.assert_allclose(heights, [vm.ARROW, 0.6 * vm.ARROW, vm.SHORTEST * vm.ARROW, 0.0], atol=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_moments_turn_right_handed(sign):
    """The circle runs from 0 to TURN about the moment's vector, the head beyond; the rest is open."""
    (arrow,) = drawn(solved(moment=[{"value": [0, 0, sign * 1e-9]}]), vm.LOAD)
    first, axis = np.array([1.0, 0.0, 0.0]), np.array([0, 0, sign])  # first: _across of either axis
    places = arrow.points - first  # from the tip of the rod
    angle = np.degrees(np.arctan2(places @ np.cross(axis, first), places @ first)) % 360.0
    assert ((angle > 40.0) & (angle < 50.0)).any()
    assert ((angle > 300.0) & (angle < 325.0)).any()  # the head, half a radius long
    assert not ((angle > 330.0) & (angle < 350.0)).any()


def test_followers_are_drawn_turned():
    bent = {"moment": [{"value": [0, 0, 0.5 * math.pi * EI]}]}  # a quarter circle: x at the tip is y now
    force = {"value": [1e-9, 0, 0], "direction": "follower"}
    meshes = drawn(solved(**bent, force=[force]), vm.LOAD)
    arrow = min(meshes, key=lambda m: m.n_points)
    extent = np.ptp(arrow.points, axis=0)
    assert extent[1] == pytest.approx(vm.ARROW, rel=0.05)
    assert extent[0] < 0.3 * vm.ARROW


def test_plates_stand_behind_clamps_and_balls_at_pins():
    (plate,) = drawn(solved(), vm.HELD)
    assert plate.bounds[1] < 0.0
    assert plate.bounds[0] > -0.03
    both = solved({"supports": [{"at": 0.0}, {"at": 1.0, "kind": "pin"}]})
    _, ball = drawn(both, vm.HELD)
    np.testing.assert_allclose(ball.center, [1.0, 0.0, 0.0], atol=1e-6)
    end = solved({"supports": [{"at": 1.0}]})
    (plate,) = drawn(end, vm.HELD)
    assert plate.bounds[0] > 1.0


def test_a_moved_clamp_is_drawn_where_it_is():
    joint = {"kind": "rigid", "a": {"rod": "arm", "at": 1.0}, "b": "ground", "displacement": [-0.05, 0, 0.1]}
    _, plate = drawn(solved({"supports": [{"at": 0.0}]}, joint=[joint]), vm.HELD)
    np.testing.assert_allclose(plate.center, [0.95, 0.0, 0.1], atol=0.02)


def test_tendons_and_chambers_lie_inside():
    path = [[0.0, 0.015, 0.0], [0.5, 0.0, 0.015], [1.0, 0.0, 0.015]]
    chamber = {"centre": [-0.008, 0.0], "radius": 0.006}
    solution = solved(
        tendon=[{"tension": 1e-9, "path": path}],
        pressure=[{"value": 1e-6, "chamber": chamber, "from": 0.2, "to": 0.6}],
    )
    (tube,), (body,) = drawn(solution, vm.TENDON), drawn(solution, vm.CHAMBER)
    assert all(mark.inside for mark in vm.marks(solution, SIZE) if mark.colour in (vm.TENDON, vm.CHAMBER))
    corner = np.array([0.5, 0.0, 0.015])
    assert np.linalg.norm(tube.points - corner, axis=1).min() < 3e-3
    assert tube.bounds[:2] == pytest.approx((0.0, 1.0), abs=3e-3)
    assert body.bounds == pytest.approx((0.2, 0.6, -0.014, -0.002, -0.006, 0.006), abs=2e-4)


def test_fields_and_rows_of_arrows():
    weight, field = {"acceleration": [0, 0, -1e-9]}, {"remanence": [1e-6, 0, 0], "field": [0, 1e-6, 0]}
    assert len(drawn(solved(gravity=weight), vm.WEIGHT)) == 1
    assert len(drawn(solved(magnet=[field]), vm.MAGNETIC)) == 5
    rows = solved(line_load=[{"value": [0, 0, -1e-9]}], line_moment=[{"value": [0, 0, 1e-9]}])
    assert len(drawn(rows, vm.LOAD)) == 2 * vm.ALONG
    (arrow,) = drawn(solved(gravity=weight), vm.WEIGHT)
    widest = arrow.points[np.argmax(np.hypot(*(arrow.points[:, :2] - arrow.center[:2]).T))]
    assert widest[2] < arrow.center[2]  # the head is below


def test_curvature_is_that_of_the_bent_rod():
    """Moment of 1.2 E I/L on a straight rod and on one curved by 0.5: kappa = 1.2 and 1.7, to (kappa R)^2."""
    for initial, expected in ((0.0, 1.2), (0.5, 1.7)):
        solution = solved({"curvature": [0, 0, initial]}, moment=[{"value": [0, 0, 1.2 * EI]}])
        (skin,), scale = skins(solution, FIELDS["curvature"])
        assert scale.title == "curvature [1/m]"
        np.testing.assert_allclose(skin.point_data[FIELD], expected, rtol=0.01)


def test_stress_falls_along_each_part_of_a_cantilever():
    """F (L - x) R/I at the root of each part, with its own R (beam theory, small load)."""
    made = {"material": ROD["material"], "elements": 8, "length": 0.5}
    parts = [{**made, "section": {"shape": "circle", "radius": r}} for r in (0.02, 0.01)]
    force = 1e-4
    scene = {"rod": [{"name": "arm", "segments": parts}], "force": [{"value": [0, 0, force]}]}
    drawn_skins, scale = skins(ancf.solve(ancf.scene_from_dict(scene)), FIELDS["stress"])
    assert scale.title == "von Mises stress [Pa]"
    for skin, start, radius in zip(drawn_skins, (0.0, 0.5), (0.02, 0.01), strict=True):
        values, x = skin.point_data[FIELD], skin.points[:, 0]
        near_root = np.abs(x - start) < 1e-4
        expected = force * (1.0 - start) * radius / (math.pi * radius**4 / 4)
        assert values[near_root].max() == pytest.approx(expected, rel=0.01)
        near_end = np.abs(x - start - 0.5) < 1e-4
        assert values[near_end].max() == pytest.approx(
            expected * (0.5 - start) / (1.0 - start), abs=0.02 * expected
        )


def test_twist_is_no_curvature():
    (skin,), _ = skins(solved(moment=[{"value": [0.5 * EI, 0, 0]}]), FIELDS["curvature"])
    assert np.abs(skin.point_data[FIELD]).max() < 1e-9


def test_thin_rods_show_curvature():
    thin = {"section": {"shape": "circle", "radius": 0.005}}
    assert telling_field(solved(thin, moment=[{"value": [0, 0, 0.004 * EI]}])) is FIELDS["curvature"]


def test_box_holds_both_shapes():
    solution = solved(moment=[{"value": [0, 0, 0.5 * math.pi * EI]}])  # a quarter circle of radius 2/pi
    low, high = box(solution)
    np.testing.assert_allclose(low, [-0.02, -0.02, -0.02], atol=1e-3)
    np.testing.assert_allclose(high, [1.02, 2 / math.pi + 0.02, 0.02], atol=2e-3)


def test_the_view_is_level_and_oblique():
    plane = solved(moment=[{"value": [0, 0, EI]}])  # in the plane of x and y, seen along z
    eye, up = _outlook(plane, None, None)
    assert abs(eye @ up) < 1e-12
    assert eye[2] > 0.8
    assert up[1] > 0.8
    eye, up = _outlook(solved(gravity={"acceleration": [-9.81, 0, 0]}), None, None)
    assert up[0] > 0.8  # against gravity
    eye, up = _outlook(plane, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    np.testing.assert_allclose((eye, up), ((1, 0, 0), (0, 0, 1)), atol=1e-12)
