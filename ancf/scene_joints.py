"""Reading of `[[joint]]` tables; a `[[motion]]` (scene_motions.py) is a joint with the ground."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.scene import SAME_PLACE, Foundation, Joint, Place, Rod, Spring
from ancf.scene_mechanism import check_mechanism, check_redundant, position, rod_of
from ancf.scene_motions import read_motion
from ancf.scene_rods import read_direction
from ancf.scene_table import FRACTION, REQUIRED, SIGNED, Table, show
from ancf.units import LENGTH, NUMBER

Floats = NDArray[np.float64]

KINDS = ("rigid", "hinge", "ball")
KEYS = ("kind", "a", "b", "axis", "displacement", "rotation", "reference")
REFERENCES = ("together", "apart")
GROUND = "ground"
# Of the longer rod: places that should be one differ by the rounding of what was written.
COINCIDE = 1e-6


def joined_rods(data: Mapping[Any, Any], names: Sequence[str]) -> set[str]:
    """Rods that joints of the raw scene name, before anything is checked."""
    joints = data.get("joint", ())
    joints = joints if isinstance(joints, list | tuple) else ()
    entries = [joint for joint in joints if isinstance(joint, Mapping)]
    ends = [joint.get(key) for joint in entries for key in ("a", "b")]
    found = [end.get("rod", names[0] if names else "") for end in ends if isinstance(end, Mapping)]
    return {name for name in found if isinstance(name, str)}


def moved_rods(data: Mapping[Any, Any], names: Sequence[str]) -> set[str]:
    """Rods that motions of the raw scene name, before anything is checked."""
    motions = data.get("motion", ())
    motions = motions if isinstance(motions, list | tuple) else ()
    found = [m.get("rod", names[0] if names else "") for m in motions if isinstance(m, Mapping)]
    return {name for name in found if isinstance(name, str)}


def read_joints(
    entries: Sequence[Table],
    motions: Sequence[Table],
    rod_entries: Sequence[Table],
    rods: Sequence[Rod],
    elastic: Sequence[Spring | Foundation],
) -> tuple[Joint, ...]:
    """Read joints and motions; what they hold twice, or leave movable without an elastic hold, is refused."""
    joints = (
        *(_read_joint(entry, rods) for entry in entries),
        *(read_motion(entry, rods) for entry in motions),
    )
    if joints:
        check_redundant([*entries, *motions], joints, rods)
        check_mechanism(rod_entries, joints, rods, elastic)
    return joints


def _read_joint(table: Table, rods: Sequence[Rod]) -> Joint:
    table.expect_keys(KEYS)
    kind = table.word("kind", KINDS)
    ends = [_read_end(table, key, rods) for key in ("a", "b")]
    if ends[0] is None:
        ends.reverse()  # a is the section that is held, b what holds it
    a, b = ends
    if a is None:
        table.refuse(
            "a",
            "The joint holds nothing.",
            'a = "ground", b = "ground"',
            "one of the two must be a section of a rod",
            "write a = { rod = ..., at = ... }",
        )
    axis = np.array([0.0, 0.0, 1.0])
    if kind == "hinge":
        axis = read_direction(table, "axis", REQUIRED)
    elif "axis" in table.data:
        _refuse_key(table, "axis", kind, "only a hinge has an axis")
    if b is not None:
        apart = table.word("reference", REFERENCES, REFERENCES[0]) == "apart"
        if apart and kind == "hinge":
            _refuse_key(table, "reference", kind, "its axis lies in both sections at the reference")
        _check_together(table, a, b, rods, apart)
        for key in ("displacement", "rotation"):
            if key in table.data:
                _refuse_key(table, key, "joint of two rods", "a section is moved against the ground")
        if apart:
            return Joint(kind, a, b, axis, apart=True)
    elif "reference" in table.data:
        _refuse_key(table, "reference", "joint to the ground", "displacement and rotation move it there")
    elif kind == "ball" and "rotation" in table.data:
        _refuse_key(table, "rotation", kind, "a ball leaves all rotations free")
    elif kind == "hinge":
        rotation = table.vector("rotation", 3, NUMBER, (0.0, 0.0, 0.0), SIGNED)
        if abs(rotation @ axis) > 1e-9 * np.linalg.norm(rotation):
            _refuse_key(table, "rotation", "hinge about that axis", "a hinge leaves it free")
    return Joint(
        kind,
        a,
        b,
        axis,
        table.vector("displacement", 3, LENGTH, (0.0, 0.0, 0.0), SIGNED),
        table.vector("rotation", 3, NUMBER, (0.0, 0.0, 0.0), SIGNED),
    )


def _refuse_key(table: Table, key: str, what: str, why: str) -> None:
    table.refuse(
        key,
        f'"{key}" does not belong to a {what}.',
        f"{key} = {show(table.data[key])}",
        why,
        f"remove {key}, or choose another kind of joint",
    )


def _read_end(table: Table, key: str, rods: Sequence[Rod]) -> Place | None:
    """Read a place { rod, at }, or the ground as None."""
    if isinstance(table.data.get(key), str):
        table.word(key, (GROUND,))
        return None
    end = table.table(key)
    end.expect_keys(("rod", "at"))
    names = [rod.name for rod in rods]
    name = end.known("rod", names, "rod", "the joint holds a rod that the scene does not list")
    return Place(name, end.number("at", NUMBER, limit=FRACTION))


def _check_together(table: Table, a: Place, b: Place, rods: Sequence[Rod], may_be_apart: bool) -> None:
    """Refuse a joint of two places apart, unless they may be, and of a section with itself."""
    if a.rod == b.rod and abs(a.at - b.at) < SAME_PLACE:
        table.refuse(
            "b",
            "The joint holds a section to itself.",
            f"a and b are rod {show(a.rod)} at {a.at:g}",
            "a copied line, or another rod was meant",
            'name another rod or place, or b = "ground"',
        )
    apart = float(np.linalg.norm(position(a, rods) - position(b, rods)))
    length = max(rod_of(place, rods).length for place in (a, b))
    if not (may_be_apart or apart <= COINCIDE * length):
        table.refuse(
            "b",
            "The two places of the joint are apart in the reference.",
            f"{apart:.3g} m, must be <= {COINCIDE:g} of the longer rod, {COINCIDE * length:.3g} m",
            "base, length or curvature of a rod does not bring it there, or `at` counts from the other end",
            'move a rod\'s base.position, or write reference = "apart": the load factor then closes the gap',
        )
