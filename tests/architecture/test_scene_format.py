"""The reference of the scene file, examples/scene-format.md, against the keys that the readers know."""

import re
from pathlib import Path

import pytest

import ancf
from ancf.scene_table import Table

EXAMPLES = Path(__file__).parents[2] / "examples"
TEXT = (EXAMPLES / "scene-format.md").read_text(encoding="utf-8")
VARIANTS = {"rod.section", "rod.material", "contact.with"}  # their keys depend on a shape or a law

ROD = {
    "length": 1.0,
    "elements": 2,
    "section": {"shape": "circle", "radius": 0.01},
    "material": {"young_modulus": 1e6, "poisson_ratio": 0.3},
}
SECTIONS = (
    {"shape": "annulus", "radius": 0.01, "inner_radius": 0.005},
    {"shape": "rectangle", "height_y": 0.01, "width_z": 0.02},
    {"shape": "ellipse", "semi_axis_y": 0.01, "semi_axis_z": 0.02},
    {"shape": "polygon", "points": [[0, 0], [0.01, 0], [0, 0.01]]},
)
BODIES = (
    {"shape": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]},
    {"shape": "sphere", "centre": [0, -1, 0], "radius": 0.1},
    {"shape": "cylinder", "point": [0, -1, 0], "axis": [0, 0, 1], "radius": 0.1},
    {"shape": "rod", "name": "rod"},
)
RUBBER = {"law": "mooney-rivlin", "c10": 1e5, "c01": 1e5, "bulk_modulus": 1e8}
PATH = [[0, 0.005, 0], [1, 0.005, 0]]
FRAME = [
    ROD | {"name": "a", "supports": [{"at": 0.0}]},
    ROD | {"name": "b", "base": {"position": [1, 0, 0]}},
]
SCENES = (
    *({"rod": [ROD | {"section": section}]} for section in SECTIONS),
    {"rod": [ROD | {"material": RUBBER, "supports": [{"at": 0.0}]}]},
    {"rod": [{"segments": [{key: ROD[key] for key in ("length", "elements", "section", "material")}]}]},
    {"rod": [ROD], "contact": [{"with": body} for body in BODIES]},
    {"rod": FRAME, "joint": [{"kind": "rigid", "a": {"rod": "a", "at": 1.0}, "b": {"rod": "b", "at": 0.0}}]},
    {
        "rod": [ROD | {"material": ROD["material"] | {"density": 1000.0}}],
        "moment": [{"value": [0, 0, 0]}],
        "force": [{"value": [0, 0, 0]}],
        "line_load": [{"value": [0, 0, 0]}],
        "line_moment": [{"value": [0, 0, 0]}],
        "magnet": [{"remanence": [0, 0, 0], "field": [0, 0, 0]}],
        "gravity": {"acceleration": [0, 0, 0]},
        "tendon": [{"tension": 0.0, "path": PATH}],
        "pressure": [{"value": 0.0, "chamber": {"radius": 0.005}}],
        "spring": [{"stiffness": 0.0}],
        "foundation": [{"stiffness": 0.0}],
        "motion": [{"displacement": [0, 0, 0]}],
        "solver": {},
    },
    {"rod": [ROD], "stability": {}},
)


def documented() -> dict[str, set[str]]:
    """Keys of the tables of the text, by the path of the table."""
    found: dict[str, set[str]] = {}
    for part in re.split(r"^##+ ", TEXT, flags=re.MULTILINE)[1:]:
        heading, _, body = part.partition("\n")
        for name in re.findall(r"`\[*([\w.]+)\]*`", heading):
            found[name] = set(re.findall(r"^\| `(\w+)` \|", body, re.MULTILINE))
    return found


@pytest.fixture(scope="module")
def known() -> dict[str, set[str]]:
    """Keys that the readers expect, by the path of the table without its numbers."""
    found: dict[str, set[str]] = {}
    expect = Table.expect_keys

    def record(self: Table, keys, later=()):
        path = re.sub(r"\[\d+\]", "", self.path)
        path = re.sub(r"^rod\.segments\.(section|section_end|material)$", r"rod.\1", path)
        path = path.replace("section_end", "section")
        # A motion goes on as a joint, under its own path: the first reader counts.
        if path in VARIANTS or path not in found:
            found.setdefault(path, set()).update(keys)
        expect(self, keys, later)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Table, "expect_keys", record)
        for scene in SCENES:
            ancf.scene_from_dict(scene)
    return found


def test_every_table_and_key_is_documented(known):
    tables = {path: keys for path, keys in known.items() if path not in ("", "motion.a")}
    assert tables == documented()


def test_every_table_of_a_scene_has_a_section(known):
    assert known[""] - {"title"} == {name for name in documented() if "." not in name}
