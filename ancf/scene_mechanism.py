r"""The refusal of structures that can move, and of joints that hold what is held already.

For small motions of rigid rods, t_i + w_i x r each, supports, joints, springs and beds are linear conditions.
If they have less than six independent ones for each rod, the structure is a mechanism. Rods bend, so the
sections of one rod move freely against each other: conditions that depend on each other at one place (a joint
at a clamp, a ring of joints round a point) would leave the forces between them unknown.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ancf.mesh import reference_axis
from ancf.rotation import hat
from ancf.scene import SAME_PLACE, Foundation, Joint, Place, Rod, Spring
from ancf.scene_table import Table, show

Floats = NDArray[np.float64]

# Singular value of the conditions, dimensionless, below which one of them says nothing new.
INDEPENDENT = 1e-6
BED_POINTS = 5  # at which a bed is looked at; three off one line hold a rod


def rod_of(place: Place, rods: Sequence[Rod]) -> Rod:
    """The rod of a place."""
    return next(rod for rod in rods if rod.name == place.rod)


def position(place: Place, rods: Sequence[Rod]) -> Floats:
    """Position (3,) [m] of a section in the reference, in SCS."""
    rod = rod_of(place, rods)
    position, _ = reference_axis(np.array([place.at * rod.length]), rod.curvature)
    return rod.base.position + rod.base.rotation @ position[0]


def _turns_held(joint: Joint) -> Floats:
    """Rows (k, 3) of the rotations that a joint holds."""
    if joint.kind == "rigid":
        return np.eye(3)
    return {"hinge": joint.across, "twist": joint.axis[None]}.get(joint.kind, np.empty((0, 3)))


def _rows(joint: Joint, columns: Sequence[int], arms: Sequence[Floats], size: int) -> Floats:
    """Conditions (k, size) of a joint on motions (t, w) that begin at `columns`; arms (3,) to the joint."""
    along, turns = joint.along, _turns_held(joint)
    count = len(along)
    rows = np.zeros((count + len(turns), size))
    for sign, column, arm in zip((1.0, -1.0), columns, arms, strict=False):
        rows[:count, column : column + 3] += sign * along
        rows[:count, column + 3 : column + 6] -= sign * along @ hat(arm)
        rows[count:, column + 3 : column + 6] += sign * turns
    return rows


def check_redundant(entries: Sequence[Table], joints: Sequence[Joint], rods: Sequence[Rod]) -> None:
    """Refuse the first joint whose conditions are not independent of the supports and joints before it."""
    places: list[Place] = []
    for joint in joints:
        for place in joint.places:
            if not any(_same(place, other) for other in places):
                places.append(place)
    size = 6 * len(places)
    free = np.ones(size)
    for index, place in enumerate(places):
        for support in rod_of(place, rods).supports:
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


def _held(elastic: Spring | Foundation, rod: Rod) -> list[tuple[Floats, Floats, Floats]]:
    """Points (3,) [m] held elastically in the reference; directions (k, 3) of displacements, of rotations."""
    ends = (elastic.at, elastic.at) if isinstance(elastic, Spring) else (elastic.start, elastic.end)
    place = np.linspace(*ends, 1 if isinstance(elastic, Spring) else BED_POINTS)
    axis, frames = reference_axis(place * rod.length, rod.curvature)
    frames = rod.base.rotation @ frames
    points = rod.base.position + axis @ rod.base.rotation.T
    if isinstance(elastic, Foundation):
        axes = frames if elastic.axes is None else np.broadcast_to(elastic.axes, frames.shape)
        along, turning = elastic.stiffness > 0.0, elastic.rotational_stiffness > 0.0
        return [(r, A.T[along], A.T[turning]) for r, A in zip(points, axes, strict=True)]
    point = points[0] + frames[0][:, 1:] @ elastic.offset
    turning = _stiff_directions(elastic.rotational_stiffness)
    if elastic.anchor is not None:
        line = elastic.anchor - point
        distance = float(np.linalg.norm(line))
        free = distance if elastic.free_length is None else elastic.free_length
        if free >= distance > 0.0 and elastic.stiffness[0, 0] > 0.0:
            return [(point, line[None] / distance, turning)]  # not pulled: it holds along its line only
    return [(point, _stiff_directions(elastic.stiffness), turning)]


def _stiff_directions(stiffness: Floats) -> Floats:
    """Principal directions (k, 3) of a stiffness (3, 3) that are not free."""
    values, directions = np.linalg.eigh(stiffness)
    return directions.T[values > INDEPENDENT * values.max()]


def check_mechanism(
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
        return (position(place, rods) - rod_of(place, rods).base.position) / length

    rows = [_rows(j, [first[p.rod] for p in j.places], [arm(p) for p in j.places], size) for j in joints]
    for rod in rods:
        for support in rod.supports:
            place = Place(rod.name, support.at)
            kind = "ball" if support.kind == "pin" else "rigid"
            rows.append(_rows(Joint(kind, place), [first[rod.name]], [arm(place)], size))
    for spring in elastic:
        rod = next(rod for rod in rods if rod.name == spring.rod)
        for point, along, turning in _held(spring, rod):
            held = np.zeros((len(along) + len(turning), size))
            column, count = first[rod.name], len(along)
            held[:count, column : column + 3] = along
            held[:count, column + 3 : column + 6] = -along @ hat((point - rod.base.position) / length)
            held[count:, column + 3 : column + 6] = turning
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
