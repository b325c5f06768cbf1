"""Variants of a scene describe the same rod; a variant that does not is caught."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import ancf
from validation import hard_cases, hard_drift, hard_threads
from validation.hard_drift import drift, shape_of
from validation.hard_scenes import LENGTH, arm, force, moment

# Every kind of load, an offset, a curved reference that is twisted, a base that is not at the origin, and a
# section whose two axes differ: whatever a variant forgets to change shows.
RICH = arm(
    elements=4,
    section={"shape": "rectangle", "height_y": 0.02, "width_z": 0.03},
    base={"position": [0.1, -0.2, 0.3], "x_axis": [1.0, 0.2, 0.0], "y_axis": [0.0, 1.0, 0.5]},
    curvature=[1.0, -2.0, 1.5],
    moment=[moment([0.1, 0.2, 0.3]), moment([0.2, 0.0, 0.1], at=0.5, direction="follower")],
    force=[force([0.5, 0.3, -0.4], offset=[0.004, 0.006]), force([0.1, 0.3, 0.2], direction="follower")],
    line_load=[{"value": [0.01, 0.02, 0.0]}],
    gravity={"acceleration": [0.0, 1.0, -2.0]},
)
TWO = {"rod": [{**RICH["rod"][0], "name": "a"}, {**arm(elements=3)["rod"][0], "name": "b"}],
       "force": [force([0, 1, 0], rod="a"), force([0, 0, 2], rod="b")]}  # fmt: skip


def solved(scene):
    solution = ancf.solve(ancf.scene_from_dict(scene))
    assert solution.status == "converged"
    return solution


def drift_of(scene, variant):
    original, other = solved(scene), solved(variant.scene)
    lengths = [rod.rod.length for rod in original.model.rods]
    return drift(shape_of(original), variant.restore(shape_of(other)), lengths)


@pytest.mark.parametrize("name", hard_cases.VARIANTS)
@pytest.mark.parametrize("scene", [RICH, TWO], ids=["every load", "two rods"])
def test_a_variant_is_the_same_rod(name, scene):
    assert drift_of(scene, hard_cases.VARIANTS[name](scene)) < 1e-11


@pytest.mark.parametrize("name", hard_cases.VARIANTS)
def test_a_variant_is_another_scene(name):
    """Else it could not show anything."""
    variant = hard_cases.VARIANTS[name](RICH)
    assert variant.scene != RICH
    assert hard_cases.VARIANTS[name](RICH).scene == variant.scene  # and the original is left alone


@pytest.mark.parametrize("name", hard_cases.VARIANTS)
@pytest.mark.parametrize(
    "spoil",
    [
        lambda scene: scene["moment"][0].update(value=[1.001 * v for v in scene["moment"][0]["value"]]),
        lambda scene: scene["rod"][-1].update(length=1.0001 * scene["rod"][-1]["length"]),
        lambda scene: scene["rod"][-1]["material"].update(young_modulus=1.001e6),
    ],
    ids=["moment", "length", "modulus"],
)
def test_a_variant_that_is_not_the_same_rod_is_caught(name, spoil):
    variant = hard_cases.VARIANTS[name](RICH)
    spoil(variant.scene)
    assert drift_of(RICH, variant) > 1e-6


@pytest.mark.parametrize("forgotten", ["force", "moment", "line_load", "gravity"])
def test_a_turn_that_forgets_a_load_is_caught(forgotten):
    variant = hard_drift.turned(RICH)
    wrong = replace(variant, scene={**variant.scene, forgotten: RICH[forgotten]})
    assert drift_of(RICH, wrong) > 1e-5


def test_what_a_variant_writes():
    """Numbers of the scene that the drift does not depend on, or hardly."""
    rod = {**RICH["rod"][0], "supports": [{"at": 0.0, "kind": "clamp"}, {"at": 1.0, "kind": "pin"}]}
    scene = {**RICH, "rod": [rod, {**rod, "name": "other"}]}
    small = hard_drift.in_millimetres(scene).scene
    assert small["rod"][1]["base"]["position"] == pytest.approx([100.0, -200.0, 300.0])
    assert small["rod"][0]["material"]["young_modulus"] == 1e6  # g/(mm s2) is Pa
    other = hard_drift.renumbered(scene).scene
    assert [r["name"] for r in other["rod"]] == ["stranger", "other", "rod"]
    assert [s["kind"] for s in other["rod"][-1]["supports"]] == ["pin", "clamp"]
    assert [load["at"] for load in other["moment"] if "at" in load] == [0.5]
    assert other["moment"][0]["value"] == RICH["moment"][1]["value"]
    assert all(load["rod"] == "rod" for load in other["force"])
    far = hard_drift.moved(scene).scene
    assert far["rod"][0]["base"]["position"] == pytest.approx([1e6 + 0.1, -1e6 - 0.2, 1e6 + 0.3], abs=1e-9)


def test_one_ulp_changes_one_input_by_one_ulp():
    changes = dict(
        hard_drift.one_ulp(arm(force=[force([0, 1.0, 0])], gravity={"acceleration": [0, 0, -2.0]}))
    )
    assert list(changes) == ["length", "section", "stiffness", "loads"]
    assert changes["length"].scene["rod"][0]["length"] == np.nextafter(LENGTH, math.inf)
    assert changes["section"].scene["rod"][0]["section"]["radius"] == np.nextafter(0.01, math.inf)
    assert changes["stiffness"].scene["rod"][0]["material"]["young_modulus"] == np.nextafter(1e6, math.inf)
    loads = changes["loads"].scene
    assert loads["gravity"]["acceleration"] == [0, 0, np.nextafter(-2.0, -math.inf)]
    assert loads["force"][0]["value"][0] == 0.0  # a load that is not there is not made
    assert loads["force"][0]["value"][1] == np.nextafter(force([0, 1.0, 0])["value"][1], math.inf)
    assert "loads" not in dict(hard_drift.one_ulp(arm()))


def test_the_largest_distance_of_all_nodes_and_rods_counts():
    one, two = np.zeros((3, 3)), np.zeros((2, 3))
    far = one.copy()
    far[1] = [0.03, 0.0, 0.04]
    assert drift([one, two], [far, two + np.array([0, 0, 0.01])], [0.5, 0.1]) == pytest.approx(0.1)
    assert drift([one, two], [far, two + np.array([0, 0, 0.02])], [0.5, 0.1]) == pytest.approx(0.2)
    assert math.isnan(drift([one], [one[:2]], [1.0]))
    assert math.isnan(drift([one], [one + math.nan], [1.0]))


def test_body_axes_are_refused():
    scene = arm(force=[force([0, 1, 0], frame="body")])
    with pytest.raises(ValueError, match="axes of the structure"):
        hard_drift.turned(scene)


def test_processes_with_their_own_threads():
    name = "full circle, L/R = 40"
    found = [hard_threads.shapes_with(n, (name,)) for n in (1, 2)]
    assert all(list(shapes) == [name] for shapes in found)
    case = next(case for case in hard_cases.hard_cases() if case.name == name)
    here = shape_of(hard_cases.solve_case(case, case.scene))
    assert max(drift(here, shapes[name], [LENGTH]) for shapes in found) < 1e-12
