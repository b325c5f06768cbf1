"""Reading of the springs and elastic foundations that a scene lists."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ancf.scene import SAME_PLACE, Foundation, Rod, Spring
from ancf.scene_cable import refuse_on_cable
from ancf.scene_table import FRACTION, SIGNED, Limit, Table
from ancf.units import LENGTH, NUMBER, ROTATIONAL_BED, ROTATIONAL_STIFFNESS, STIFFNESS, STRESS, Dimension

NOT_NEGATIVE = Limit(lambda v: v >= 0.0, ">= 0")
FRAMES = ("structure", "body", "section")


def read_spring(table: Table, rods: Sequence[Rod]) -> Spring:
    """Read one `[[spring]]`: the point that it holds, its stiffness, and what it holds it to."""
    keys = (
        "rod",
        "at",
        "offset",
        "stiffness",
        "rotational_stiffness",
        "frame",
        "to",
        "anchor",
        "free_length",
    )
    table.expect_keys(keys)
    rod = _rod_of(table, rods)
    at = table.number("at", NUMBER, 1.0, FRACTION)
    offset = table.vector("offset", 2, LENGTH, (0.0, 0.0))
    if any(offset):
        why = "a lever arm needs a section that turns"
        refuse_on_cable(table, rod, "offset", "A spring holds a cable by its axis only.", why)
        if not rod.section_at(at).contains(*offset):
            table.refuse(
                "offset",
                "The spring holds no point of the section.",
                f"offset = [{offset[0]:g}, {offset[1]:g}] m lies outside, the section reaches"
                f" {rod.section_at(at).outer_radius:.4g} m",
                "offset is measured from the axis in metres, or the wrong rod is named",
                "move the point into the section",
            )
    anchored = table.word("to", ("reference", "anchor"), "anchor" if "anchor" in table.data else "reference")
    if anchored == "anchor":
        given = "free_length" in table.data
        free = table.number("free_length", LENGTH, limit=NOT_NEGATIVE) if given else None
        k = table.number("stiffness", STIFFNESS, limit=NOT_NEGATIVE)
        why = "it acts along its line, whatever the axes, and has no lever"
        _refuse_keys(table, ("frame", "rotational_stiffness"), "to an anchor", why)
        anchor = table.vector("anchor", 3, LENGTH, limit=SIGNED)
        return Spring(rod.name, at, k * np.eye(3), offset, anchor, free)
    _refuse_keys(table, ("anchor", "free_length"), "to the reference", "it is free of force there")
    axes = _axes(table, rod, ("structure", "body"))
    assert axes is not None
    stiffness, turning = _stiffnesses(table, rod, STIFFNESS, ROTATIONAL_STIFFNESS)
    return Spring(
        rod.name,
        at,
        (axes * stiffness) @ axes.T,
        offset,
        rotational_stiffness=(axes * turning) @ axes.T,
    )


def read_foundation(table: Table, rods: Sequence[Rod]) -> Foundation:
    """Read one `[[foundation]]`: its stiffness per length, and the part of the rod that lies on it."""
    table.expect_keys(("rod", "stiffness", "rotational_stiffness", "frame", "from", "to"))
    rod = _rod_of(table, rods)
    start, end = table.number("from", NUMBER, 0.0, FRACTION), table.number("to", NUMBER, 1.0, FRACTION)
    if end - start <= SAME_PLACE:
        table.refuse(
            "to",
            "The foundation has no length.",
            f"from = {start:g}, to = {end:g}",
            "both are fractions of the length, from below to",
            "exchange them, or leave both away for the whole rod",
        )
    stiffness, turning = _stiffnesses(table, rod, STRESS, ROTATIONAL_BED)
    return Foundation(rod.name, stiffness, _axes(table, rod, FRAMES), start, end, turning)


def _stiffnesses(
    table: Table, rod: Rod, along: Dimension, about: Dimension
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Three stiffnesses along the axes and three about them; what is not given is zero, but one is needed."""
    if "rotational_stiffness" not in table.data:
        return _stiffness(table, "stiffness", along), np.zeros(3)
    why = "a rotation is that of a section, and a cable has none"
    refuse_on_cable(table, rod, "rotational_stiffness", "No spring turns a cable.", why)
    given = "stiffness" in table.data
    return (
        _stiffness(table, "stiffness", along) if given else np.zeros(3),
        _stiffness(table, "rotational_stiffness", about),
    )


def _stiffness(table: Table, key: str, dimension: Dimension) -> NDArray[np.float64]:
    """Three stiffnesses along the axes, from one for all or from three."""
    value = table.data.get(key)
    if isinstance(value, list | tuple | np.ndarray):
        return table.vector(key, 3, dimension, limit=NOT_NEGATIVE)
    return np.full(3, table.number(key, dimension, limit=NOT_NEGATIVE))


def _axes(table: Table, rod: Rod, frames: Sequence[str]) -> NDArray[np.float64] | None:
    """Axes (3, 3) of the stiffnesses as columns in SCS; None for those of each reference section."""
    frame = table.word("frame", frames, "structure")
    return {"structure": np.eye(3), "body": rod.base.rotation, "section": None}[frame]


def _refuse_keys(table: Table, keys: Sequence[str], which: str, why: str) -> None:
    for key in keys:
        if key in table.data:
            table.refuse(
                key,
                f"A spring {which} has no {key}.",
                f"{key} is given",
                why,
                f"remove {key}, or choose what the spring holds the point to (to = ...)",
            )


def _rod_of(table: Table, rods: Sequence[Rod]) -> Rod:
    names = [rod.name for rod in rods]
    name = table.known("rod", names, "rod", "it holds a rod that the scene does not list")
    return rods[names.index(name)]
