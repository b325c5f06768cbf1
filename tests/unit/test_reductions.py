"""Which reductions a scene gets, and what keeps it from being planar."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import ancf
from ancf import scene_plane
from ancf.effects.tendon import PulledTendon
from ancf.errors import Message
from ancf.model import Model
from ancf.reductions import has_potential
from ancf.rotation import exp
from ancf.scene import (
    Force,
    Foundation,
    Frame,
    Gravity,
    LineLoad,
    LineMoment,
    Magnet,
    Moment,
    Pressure,
    Scene,
    SolverOptions,
    Spring,
    Tendon,
)
from ancf.scene_plane import find_plane, is_mirrored
from ancf.sections import Annulus, Circle, Ellipse, Polygon, Rectangle
from tests.planar_scenes import (
    LOADS,
    MOMENT,
    OBLIQUE,
    TRAPEZIUM,
    arm,
    both,
    distance,
    find,
    is_planar,
    scene,
)


def test_full_is_lu_on_all_unknowns():
    _, full = both(scene(arm()))
    assert full.reductions == []
    assert type(full.model) is Model


def test_oblique_loads_are_symmetric_only():
    one = scene(arm(section=Rectangle(0.02, 0.01)), gravity=Gravity(np.array([0.0, 0.0, 1.0])))
    lean, full = both(one)
    assert [s.split(":")[0] for s in lean.reductions] == ["symmetric"]
    assert lean.stable is full.stable is True
    assert distance(lean, full) < 1e-12
    twisted = replace(one, moments=(Moment("arm", 1.0, np.array([1.0, 0, 0]) * MOMENT),))
    assert ancf.solve(twisted).reductions == []
    spread = replace(one, line_moments=(LineMoment("arm", np.array([1.0, 0, 0]) * MOMENT),))
    assert ancf.solve(spread).reductions == []


def test_a_short_rod_under_moments_alone_is_solved_in_full():
    """There the plane costs more than it saves; `planar` insists on it, and the answer is the same."""
    short = scene(arm(), forces=(), **LOADS["moment"])
    assert ancf.solve(short).reductions == []
    planar, full = both(short, insist=True)
    assert is_planar(planar) and distance(planar, full) < 1e-12
    for more in (
        replace(short, rods=(arm(elements=12),)),
        replace(short, forces=scene(arm()).forces),
        replace(short, gravity=Gravity(np.array([0.0, -1.0, 0.0]))),
    ):
        assert is_planar(ancf.solve(more))


def test_a_cable_is_proposed_where_nothing_needs_sections():
    """What it leaves out, shear: 3 E I/(G A L^2) of a cantilever's deflection (Timoshenko's beam)."""
    proposed = ancf.solve(scene(arm())).reductions[-1]
    assert proposed.startswith("cable, on request") and 'element = "cable"' in proposed
    assert "some 0.001 of" in proposed  # 3 (R/(2 L))^2 2 (1 + nu) = 1.2e-3
    for one in (
        scene(arm(element="cable")),
        scene(arm(section=Rectangle(0.02, 0.01))),
        scene(arm(curvature=np.array([0.0, 0.0, 1.0]))),
        *(
            scene(arm(), **LOADS[load])
            for load in ("moment", "lever", "follower", "tendon", "chamber", "magnet")
        ),
    ):
        assert not any(sentence.startswith("cable") for sentence in ancf.solve(one).reductions)
    assert ancf.solve(replace(scene(arm()), solver=SolverOptions(reduction="full"))).reductions == []


LEAVING = {
    "force[0]": scene(arm(), moments=(Moment("arm", 1.0, np.array([0, 0, MOMENT])),),
                      forces=(Force("arm", 1.0, np.array([0, 1.0, 0.5])),)),
    "moment[1]": scene(arm(), moments=(Moment("arm", 0.5, np.array([0, 0, MOMENT])),
                                       Moment("arm", 1.0, np.array([MOMENT, 0, 0])))),
    "force[0].offset": scene(
        arm(), forces=(Force("arm", 1.0, np.array([0, 1.0, 0]), np.array([0.0, 0.005])),)),
    "rod[0].curvature": scene(arm(curvature=np.array([1.0, 0, 0]))),
    "rod[0].section": scene(arm(section=Rectangle(0.02, 0.01)),
                            forces=(Force("arm", 1.0, np.array([0, 1.0, 1.0])),)),
    "rod[1].base": Scene((
        arm(curvature=np.array([0, 0, 1.0])),
        arm(name="other", base=Frame(np.zeros(3), np.eye(3)[:, [2, 0, 1]]))
    )),
    "gravity": scene(arm(), gravity=Gravity(np.array([0, 0, -9.81]))),
    "tendon[0].path": scene(
        arm(), tendons=(Tendon("arm", 1.0, np.array([[0, 0, 0.005], [1, 0, 0.005]])),)),
    "pressure[0].chamber": scene(arm(), pressures=(Pressure("arm", 1e4, np.array([0, 0.004]), 0.003),)),
    "magnet[0].field": scene(
        arm(), magnets=(Magnet("arm", np.array([0.1, 0, 0]), np.array([0.0, 0, 0.1])),)),
    "spring[0].stiffness": scene(
        arm(), springs=(Spring("arm", 1.0, np.array([[1.0, 0, 0], [0, 1, 0.1], [0, 0.1, 2]])),)),
    "spring[0].anchor": scene(
        arm(), springs=(Spring("arm", 1.0, np.eye(3), anchor=np.array([0.4, 0, 0.1])),)),
    "spring[0].offset": scene(arm(), springs=(Spring("arm", 1.0, np.eye(3), np.array([0.0, 0.005])),)),
    "foundation[0].stiffness": scene(
        arm(base=Frame(np.zeros(3), exp(np.array([0.3, 0, 0])))),
        foundations=(Foundation("arm", np.array([0.0, 1, 2]), None),)),
    "line_load[0]": scene(arm(), line_loads=(LineLoad("arm", np.array([0, 0, 0.1])),)),
    "line_moment[0]": scene(arm(), line_moments=(LineMoment("arm", np.array([0.01, 0, 0])),)),
}  # fmt: skip


@pytest.mark.parametrize("where", LEAVING)
def test_planar_names_what_leaves_the_plane(where: str):
    found = find_plane(LEAVING[where])
    assert isinstance(found, Message)
    assert found.what == "The scene is not planar."
    assert found.where == where
    assert 'reduction = "auto"' in found.advice
    with pytest.raises(ancf.SceneError, match="not planar"):
        ancf.solve(replace(LEAVING[where], solver=SolverOptions(reduction="planar")))


@pytest.mark.parametrize("off", [1e-3, 1e-7, 1e-11, 1e-15, 1e-40])
def test_a_load_near_the_axis_tells_the_plane_of_a_round_rod(off: float):
    along, aside = OBLIQUE[:, 0], OBLIQUE @ [0.0, 0.6, 0.8]
    rod = arm(base=Frame(np.zeros(3), OBLIQUE))
    plane = find(scene(rod, forces=(Force("arm", 1.0, along + off * aside),)))
    if off > 1e-14:  # below, rounding has the last word on which plane it is
        assert abs(plane.normal @ aside) < 1e-15 / off


def test_effects_that_the_plane_does_not_know_are_solved_in_space(monkeypatch: pytest.MonkeyPatch):
    """As if contact had come and nobody had thought of its mirror image."""
    monkeypatch.setattr(scene_plane, "UNKNOWN", (*scene_plane.UNKNOWN, "gravity"))
    one = scene(arm(), gravity=Gravity(np.array([0.0, -1.0, 0.0])))
    found = find_plane(one)
    assert isinstance(found, Message) and found.where == "gravity"
    assert not is_planar(ancf.solve(one))


def test_effects_are_asked_for_their_potential(monkeypatch: pytest.MonkeyPatch):
    """As if a tendon rubbed in its sheath: known to be in the plane, but no longer conservative."""
    one = scene(arm(), **LOADS["tendon"])
    assert any(sentence.startswith("symmetric") for sentence in ancf.solve(one).reductions)
    monkeypatch.setattr(PulledTendon, "potential", lambda self, e: None)
    rubbing = ancf.solve(one)
    assert is_planar(rubbing)
    assert not any(sentence.startswith("symmetric") for sentence in rubbing.reductions)


def test_zero_loads_are_in_every_plane():
    one = scene(arm(), moments=(Moment("arm", 1.0, np.zeros(3)),), gravity=Gravity(np.zeros(3)))
    assert has_potential(one, find(one))
    np.testing.assert_array_equal(find(one).normal, [0, 0, 1])


@pytest.mark.parametrize(
    ("section", "planes"),
    [
        (Circle(1.0), (True, True, True)),
        (Annulus(1.0, 0.5), (True, True, True)),
        (Ellipse(1.0, 0.5), (True, True, False)),
        (Rectangle(1.0, 0.5), (True, True, False)),
        (Polygon(((0, 0), (1, 0), (1, 1), (0, 1))), (True, True, True)),  # a square: its diagonals as well
        (TRAPEZIUM, (False, True, False)),
        (Polygon(((0, 0), (2, 0), (0, 1))), (False, False, False)),
    ],
)  # fmt: skip
def test_mirror_images_of_sections(section: Any, planes: tuple[bool, bool, bool]):
    half = np.sqrt(0.5)
    normals = ((1.0, 0.0), (0.0, 1.0), (half, half))
    assert tuple(is_mirrored(section, normal) for normal in normals) == planes
