"""Segments in scene files: what is read, and what is refused with file, key path, value and advice."""

# ruff: noqa: E501 - the table of refusals reads best with one case a line

from __future__ import annotations

import copy
import json
from typing import Any

import pytest

from ancf.cli import main
from ancf.errors import SceneError
from ancf.hyperelastic import NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.scene_file import scene_from_dict
from ancf.sections import Circle, Polygon
from ancf.segments import Segment
from validation.regime import regime_of

SOFT = {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
DISC = {"shape": "circle", "radius": 0.01}
THIN = {"shape": "circle", "radius": 0.004}
PIECE = {"length": 0.2, "elements": 4, "section": DISC, "material": SOFT}
SQUARE = {"shape": "polygon", "points": [[0, 0], [2, 0], [2, 2], [0, 2]]}


def rod(*segments: dict[str, Any], **keys: Any) -> dict[str, Any]:
    """A scene whose rod has the segments, each the usual one with some other keys; None removes one."""
    merged = [{**copy.deepcopy(PIECE), **segment} for segment in segments]
    made = [{key: value for key, value in segment.items() if value is not None} for segment in merged]
    return {"rod": [{"segments": made, **keys}]}


def test_segments_are_read():
    law = {"law": "neo-hookean", **SOFT, "poisson_ratio": 0.4}
    scene = scene_from_dict(rod({"length": "20 cm", "section_end": THIN}, {"material": law, "elements": 6}))
    first, second = scene.rods[0].segments
    assert first == Segment(0.2, 4, Circle(0.01), SaintVenantKirchhoff(1e6, 0.3, 1000.0), Circle(0.004))
    assert second == Segment(0.2, 6, Circle(0.01), NeoHookean(1e6, 0.4, 1000.0))
    assert (scene.rods[0].length, scene.rods[0].elements) == (0.4, 10)


def test_one_prismatic_segment_is_a_plain_rod():
    assert scene_from_dict(rod({})).rods[0].segments == ()
    assert scene_from_dict(rod({"section_end": DISC})).rods[0].segments == ()


def test_a_force_may_stand_on_the_face_of_the_thicker_segment():
    scene = rod({}, {"section": THIN})
    scene["force"] = [{"at": 0.5, "offset": [0.009, 0], "value": [1, 0, 0]}]
    assert scene_from_dict(scene).forces[0].offset[0] == 0.009
    scene["force"][0]["at"] = 0.51
    assert "reaches 0.004 m" in str(refused(scene))


def refused(data: Any) -> SceneError:
    with pytest.raises(SceneError) as caught:
        scene_from_dict(data, "arm.toml")
    return caught.value


BOWTIE = [[0, 0], [2, 2], [2, 0], [0, 2]]
REFUSALS = [
    (rod({}, length=0.4), "rod[0].length", "both given", "length beside segments", "remove length"),
    (rod({}, elements=3, section=DISC), "rod[0].elements", "both given", "elements, section", "remove"),
    (rod({}, material=SOFT), "rod[0].material", "both given", "material beside", "remove material"),
    (rod(), "rod[0].segments", "no segments", "0 given", "at least one segment"),
    ({"rod": [{"segments": PIECE}]}, "rod[0].segments", "list of tables", "single table", "[{ ... }]"),
    (rod({}, {"length": None}), "rod[0].segments[1].length", "missing", "elements", "add length"),
    (rod({"length": -1}), "rod[0].segments[0].length", "out of range", "-1", "> 0"),
    (rod({"elements": 2.0}), "rod[0].segments[0].elements", "wrong type", "2.0", "whole"),
    (rod({"elements": 600_000}, {"elements": 600_000}), "rod[0].segments", "too many", "1200000", "fewer"),
    (rod({}, {"length": 1e-9}), "rod[0].segments[1].length", "too short", "1e-09", "join it"),
    (rod({"section_ende": DISC}), "rod[0].segments[0].section_ende", "Unknown key", "none of", "section_end"),
    (rod({"element": "3333"}), "rod[0].segments[0].element", "Unknown key", "none of", "elements"),
    (rod({"section_end": {"shape": "circle"}}), "rod[0].segments[0].section_end.radius", "missing", "shape", "add radius"),
    (rod({"section_end": {"shape": "ellipse", "semi_axis_y": 1, "semi_axis_z": 1}}), "rod[0].segments[0].section_end",
     "change the shape", "a circle, section_end a ellipse", "two segments"),
    (rod({"section": SQUARE, "section_end": {"shape": "polygon", "points": [[0, 0], [1, 0], [0, 1]]}}),
     "rod[0].segments[0].section_end", "different numbers of corners", "4, section_end 3", "same number"),
    (rod({"section": SQUARE, "section_end": {"shape": "polygon", "points": [[2, 2], [0, 2], [0, 0], [2, 0]]}}),
     "rod[0].segments[0].section_end", "breaks down along the taper", "no area", "same corner"),
    (rod({"material": {"young_modulus": 1e6, "poisson_ratio": 0.6}}), "rod[0].segments[0].material.poisson_ratio",
     "out of range", "0.6", "inside"),
    (rod({"elements": 1}, {}, supports=[{"at": 0.0}, {"at": 0.2}]), "rod[0].segments[0].elements",
     "fewer elements than pieces", "elements = 1, pieces = 2", "elements >= 2"),
    (rod({}, {"material": {**SOFT, "young_modulus": 1e18}}), "rod[0].segments[1]", "differ too much", "residual", "moduli"),
    (rod({"section": THIN, "section_end": DISC}, curvature=[0, 0, 150.0]), "rod[0].curvature", "more sharply", "0.01 m", "reduce"),
]  # fmt: skip


@pytest.mark.parametrize(("data", "path", "what", "value", "advice"), REFUSALS)
def test_refusals_say_what_where_and_value(data, path, what, value, advice):
    message = refused(data).message
    assert message.where == f"arm.toml: {path}"
    for part, text in ((what, message.what), (value, message.value + message.what), (advice, str(message))):
        assert part in text
    assert all((message.what, message.value, message.cause, message.advice))


def test_every_segment_needs_a_density_for_gravity():
    material = {"young_modulus": 1e6, "poisson_ratio": 0.3}
    scene = {**rod({}, {"material": material}), "gravity": {"acceleration": [0, 0, -9.81]}}
    assert refused(scene).message.where == "arm.toml: rod[0].segments[1].material.density"


def test_polygons_out_of_step_cross_on_the_way():
    """Both ends are simple and counter-clockwise; half way one is a bow tie of area 0."""
    ends = [
        Polygon(tuple(map(tuple, corners))) for corners in (SQUARE["points"], [*SQUARE["points"][1:], [0, 0]])
    ]
    assert all(end.area == pytest.approx(4.0) for end in ends)
    scene = rod(
        {
            "section": SQUARE,
            "section_end": {"shape": "polygon", "points": [[2, 0], [0, 2], [0, 0], [2, 2]][::-1]},
        }
    )
    assert "section_end" in refused(scene).message.where


def test_check_lists_the_segments(tmp_path, capsys):
    text = """
    [[rod]]
    name = "arm"
    [[rod.segments]]
    length = 0.2
    elements = 4
    section = { shape = "circle", radius = 0.01 }
    section_end = { shape = "circle", radius = 0.004 }
    material = { young_modulus = 1e6, poisson_ratio = 0.3 }
    [[rod.segments]]
    length = 0.1
    elements = 2
    section = { shape = "circle", radius = 0.004 }
    material = { law = "neo-hookean", young_modulus = 1e6, poisson_ratio = 0.3 }
    """
    path = tmp_path / "arm.toml"
    path.write_text(text)
    assert main(["check", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["rods"]["arm"]
    assert found["segments"][0]["section_end"] == {"shape": "circle", "radius": 0.004}
    assert found["segments"][1]["material"]["law"] == "neo-hookean"
    assert "section" not in found and found["elements"] == 6
    assert main(["check", str(path)]) == 0
    shown = capsys.readouterr().err
    assert "circle(radius = 0.01) to circle(radius = 0.004)" in shown and "0.1 m, 2 elements" in shown


def test_no_certificate_speaks_for_segments():
    """The words of the section are those of no case: cases are prismatic."""
    scene = scene_from_dict(rod({"section_end": THIN}, {}))
    words = regime_of(scene.rods[0], scene)["section"]
    assert words == ("tapered circle of saint-venant-kirchhoff, then circle of saint-venant-kirchhoff")
