r"""Reading of `[[joint]]` tables, and the refusal of mechanisms and of joints that hold twice.

For small motions of rigid rods, t_i + w_i x r each, supports, joints, springs and beds are linear conditions.
If they have less than six independent ones for each rod, the structure is a mechanism. Rods bend, so the
sections of one rod move freely against each other: conditions that depend on each other at one place (a joint
at a clamp, a ring of joints round a point) would leave the forces between them unknown.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.mesh import reference_axis
from ancf.rotation import hat
from ancf.scene import SAME_PLACE, Foundation, Joint, Place, Rod, Spring
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
# Singular value of the conditions, dimensionless, below which one of them says nothing new.
INDEPENDENT = 1e-6
BED_POINTS = 5  # at which a bed is looked at; three off one line hold a rod


def joined_rods(data: Mapping[Any, Any], names: Sequence[str]) -> set[str]:
    """Rods that joints of the raw scene name, before anything is checked."""
    joints = data.get("joint", ())
    joints = joints if isinstance(joints, list | tuple) else ()
    entries = [joint for joint in joints if isinstance(joint, Mapping)]
    ends = [joint.get(key) for joint in entries for key in ("a", "b")]
    found = [end.get("rod", names[0] if names else "") for end in ends if isinstance(end, Mapping)]
    return {name for name in found if isinstance(name, str)}


def read_joints(
    entries: Sequence[Table],
    rod_entries: Sequence[Table],
    rods: Sequence[Rod],
    springs: Sequence[Spring] = (),
    foundations: Sequence[Foundation] = (),
) -> tuple[Joint, ...]:
    """Read the joints of a scene; what they hold twice, or leave movable without a spring, is refused."""
    joints = tuple(_read_joint(entry, rods) for entry in entries)
    if joints:
        _check_redundant(entries, joints, rods)
        _check_mechanism(rod_entries, joints, rods, [*springs, *foundations])
    return joints


def motion_as_joint(entry: Table) -> Table:
    """A `[[motion]]` as the joint with the ground that prescribes it: rigid, a ball for a position alone."""
    entry.expect_keys(("rod", "at", "hold", "displacement", "rotation"))
    hold = entry.word("hold", ("pose", "position"), "pose")
    if not {"displacement", "rotation"} & set(entry.data):
        entry.refuse(
            "displacement",
            "The motion moves nothing.",
            "neither displacement nor rotation",
            "a section that is only held is a support or a joint",
            'add displacement = [x, y, z], or use supports or a [[joint]] with b = "ground"',
        )
    if hold == "position" and "rotation" in entry.data:
        entry.refuse(
            "rotation",
            "The rotation is given and left free.",
            f'rotation = {show(entry.data["rotation"])} with hold = "position"',
            "a section that is held by its position alone turns as it likes",
            'write hold = "pose", or remove rotation',
        )
    place = {key: entry.data[key] for key in ("rod", "at") if key in entry.data}
    moved = {key: entry.data[key] for key in ("displacement", "rotation") if key in entry.data}
    kind = "rigid" if hold == "pose" else "ball"
    data = {"kind": kind, "a": {"at": 1.0, **place}, "b": GROUND, **moved}
    return Table(data, entry.source, entry.path)


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


def _rod_of(place: Place, rods: Sequence[Rod]) -> Rod:
    return next(rod for rod in rods if rod.name == place.rod)


def _position(place: Place, rods: Sequence[Rod]) -> Floats:
    """Position (3,) [m] of a section in the reference, in SCS."""
    rod = _rod_of(place, rods)
    position, _ = reference_axis(np.array([place.at * rod.length]), rod.curvature)
    return rod.base.position + rod.base.rotation @ position[0]


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
    apart = float(np.linalg.norm(_position(a, rods) - _position(b, rods)))
    length = max(_rod_of(place, rods).length for place in (a, b))
    if not (may_be_apart or apart <= COINCIDE * length):
        table.refuse(
            "b",
            "The two places of the joint are apart in the reference.",
            f"{apart:.3g} m, must be <= {COINCIDE:g} of the longer rod, {COINCIDE * length:.3g} m",
            "base, length or curvature of a rod does not bring it there, or `at` counts from the other end",
            'move a rod\'s base.position, or write reference = "apart": the load factor then closes the gap',
        )


def _turns_held(joint: Joint) -> Floats:
    """Rows (k, 3) of the rotations that a joint holds."""
    if joint.kind == "rigid":
        return np.eye(3)
    return joint.across if joint.kind == "hinge" else np.empty((0, 3))


def _rows(joint: Joint, columns: Sequence[int], arms: Sequence[Floats], size: int) -> Floats:
    """Conditions (k, size) of a joint on motions (t, w) that begin at `columns`; arms (3,) to the joint."""
    turns = _turns_held(joint)
    rows = np.zeros((3 + len(turns), size))
    for sign, column, arm in zip((1.0, -1.0), columns, arms, strict=False):
        rows[:3, column : column + 3] += sign * np.eye(3)
        rows[:3, column + 3 : column + 6] -= sign * hat(arm)
        rows[3:, column + 3 : column + 6] += sign * turns
    return rows


def _check_redundant(entries: Sequence[Table], joints: Sequence[Joint], rods: Sequence[Rod]) -> None:
    """Refuse the first joint whose conditions are not independent of the supports and joints before it."""
    places: list[Place] = []
    for joint in joints:
        for place in joint.places:
            if not any(_same(place, other) for other in places):
                places.append(place)
    size = 6 * len(places)
    free = np.ones(size)
    for index, place in enumerate(places):
        for support in _rod_of(place, rods).supports:
            if abs(support.at - place.at) < SAME_PLACE:
                free[6 * index : 6 * index + (3 if support.kind == "pin" else 6)] = 0.0
    rows = np.empty((0, size))
    for entry, joint in zip(entries, joints, strict=True):
        columns = [6 * next(i for i, p in enumerate(places) if _same(p, place)) for place in joint.places]
        rows = np.vstack([rows, _rows(joint, columns, [np.zeros(3)] * 2, size) * free])
        if np.linalg.matrix_rank(rows, tol=INDEPENDENT) < len(rows):
            held = ", ".join(f"rod {show(place.rod)} at {place.at:g}" for place in joint.places)
            entry.refuse(
                "",
                "The joint holds what is held already.",
                f"{held}: {len(rows) - np.linalg.matrix_rank(rows, tol=INDEPENDENT)} of its conditions say"
                " nothing new",
                "a support or other joints hold these sections against each other, so the forces would be"
                " unknown",
                "remove the joint, or the support there",
            )


def _same(a: Place, b: Place) -> bool:
    return a.rod == b.rod and abs(a.at - b.at) < SAME_PLACE


def _held_points(elastic: Spring | Foundation, rod: Rod) -> list[tuple[Floats, Floats]]:
    """Points (3,) [m] that a spring or a bed holds in the reference, and the directions (k, 3) at each."""
    ends = (elastic.at, elastic.at) if isinstance(elastic, Spring) else (elastic.start, elastic.end)
    place = np.linspace(*ends, 1 if isinstance(elastic, Spring) else BED_POINTS)
    axis, frames = reference_axis(place * rod.length, rod.curvature)
    frames = rod.base.rotation @ frames
    points = rod.base.position + axis @ rod.base.rotation.T
    if isinstance(elastic, Foundation):
        axes = frames if elastic.axes is None else np.broadcast_to(elastic.axes, frames.shape)
        return [(r, A.T[elastic.stiffness > 0.0]) for r, A in zip(points, axes, strict=True)]
    point = points[0] + frames[0][:, 1:] @ elastic.offset
    if elastic.anchor is not None:
        line = elastic.anchor - point
        distance = float(np.linalg.norm(line))
        free = distance if elastic.free_length is None else elastic.free_length
        if free >= distance > 0.0 and elastic.stiffness[0, 0] > 0.0:
            return [(point, line[None] / distance)]  # not pulled: it holds along its line only
    stiffness, directions = np.linalg.eigh(elastic.stiffness)
    return [(point, directions.T[stiffness > INDEPENDENT * stiffness.max()])]


def _check_mechanism(
    entries: Sequence[Table],
    joints: Sequence[Joint],
    rods: Sequence[Rod],
    elastic: Sequence[Spring | Foundation],
) -> None:
    """Refuse a structure that can move while neither rod nor spring strains."""
    length = max(rod.length for rod in rods)
    first = {rod.name: 6 * index for index, rod in enumerate(rods)}
    size = 6 * len(rods)

    def arm(place: Place) -> Floats:
        return (_position(place, rods) - _rod_of(place, rods).base.position) / length

    rows = [_rows(j, [first[p.rod] for p in j.places], [arm(p) for p in j.places], size) for j in joints]
    for rod in rods:
        for support in rod.supports:
            place = Place(rod.name, support.at)
            kind = "ball" if support.kind == "pin" else "rigid"
            rows.append(_rows(Joint(kind, place), [first[rod.name]], [arm(place)], size))
    for spring in elastic:
        rod = next(rod for rod in rods if rod.name == spring.rod)
        for point, directions in _held_points(spring, rod):
            held = np.zeros((len(directions), size))
            column = first[rod.name]
            held[:, column : column + 3] = directions
            held[:, column + 3 : column + 6] = -directions @ hat((point - rod.base.position) / length)
            rows.append(held)
    _, singular, motions = np.linalg.svd(np.vstack(rows))
    free = size - int(np.count_nonzero(singular > INDEPENDENT))
    if free:
        share = np.sum(motions[size - free :].reshape(free, len(rods), 6) ** 2, axis=(0, 2))
        index = int(np.argmax(share))
        entries[index].refuse(
            "supports",
            "The structure is a mechanism.",
            f"{free} of its motions strain neither rod nor spring; rod {show(rods[index].name)} moves most",
            "a rod that a joint holds has no default clamp, and hinges and balls leave rotations free",
            'clamp a rod, for example supports = [{ at = 0.0 }], make joints "rigid", or add a [[spring]]',
        )
