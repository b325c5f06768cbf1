"""Reading of a rod's `segments`: pieces with their own length, section, taper, material and elements."""

from __future__ import annotations

from typing import Any

import numpy as np

from ancf.scene_materials import read_material
from ancf.scene_sections import THINNEST, crossing_edges, read_section, thinness
from ancf.scene_table import SIZE, Table, show
from ancf.sections import Polygon, Section
from ancf.segments import Segment, between, starts
from ancf.units import LENGTH

WHOLE_ROD_KEYS = ("length", "elements", "section", "material")  # what segments stand in the place of
SEGMENT_KEYS = ("length", "elements", "section", "section_end", "material")
MOST_SEGMENTS = 10_000
# Of the rod's length: positions are stored to 1e-16 of it, which would be 1e-9 of a shorter segment.
SHORTEST = 1e-7
# A polygon is looked at in so many places between its ends: corners move along straight lines, so what is in
# order there can fail between two places by a hair only.
PLACES = 32


def read_elements(table: Table, most: int, meshed: bool) -> int:
    """Read `elements`; 0 for a rod whose mesh `accuracy` chooses, which refuses the key."""
    if meshed:
        return table.whole("elements", 1, most)
    if "elements" in table.data:
        table.refuse(
            "elements",
            "Elements and accuracy are both given.",
            f"elements = {show(table.data['elements'])} beside accuracy in [solver]",
            "accuracy stands in the place of elements: the program chooses the mesh",
            "remove elements, or accuracy",
        )
    return 0


def read_segments(table: Table, most_elements: int, meshed: bool = True) -> tuple[Segment, ...]:
    """Read the segments of a rod; keys of the whole rod that they stand in the place of are refused."""
    twice = [key for key in WHOLE_ROD_KEYS if key in table.data]
    if twice:
        table.refuse(
            twice[0],
            f'"{twice[0]}" and "segments" are both given.',
            f"{', '.join(twice)} beside segments",
            f"segments stand in place of {', '.join(WHOLE_ROD_KEYS)}: each has its own",
            f"remove {', '.join(twice)} from the rod, or the segments",
        )
    entries = table.tables("segments")
    if not 1 <= len(entries) <= MOST_SEGMENTS:
        table.refuse(
            "segments",
            f"The rod has {len(entries) or 'no'} segments.",
            f"{len(entries)} given; 1 to {MOST_SEGMENTS} are needed",
            "an empty list, or one that a program wrote in the place of a taper",
            "list at least one segment, or give the rod its own keys; for a taper there is section_end",
        )
    segments = tuple(_segment(entry, most_elements, meshed) for entry in entries)
    total = float(starts(segments)[-1])
    for entry, segment in zip(entries, segments, strict=True):
        if segment.length < SHORTEST * total:
            entry.refuse(
                "length",
                "The segment is too short for its rod.",
                f"length = {segment.length:g} m of {total:g} m, must be >= {SHORTEST:g} of it",
                "a length in another unit, or a joint drawn as a segment",
                "join it to its neighbour, or check its length [m]",
            )
    count = sum(segment.elements for segment in segments)
    if count > most_elements:
        table.refuse(
            "segments",
            "The segments have too many elements.",
            f"{count} in all, must be <= {most_elements}",
            "a slip of the keyboard is likely",
            "take fewer elements",
        )
    return segments


def _segment(table: Table, most_elements: int, meshed: bool) -> Segment:
    table.expect_keys(SEGMENT_KEYS)
    section = read_section(table.table("section"))
    return Segment(
        length=table.number("length", LENGTH, limit=SIZE),
        elements=read_elements(table, most_elements, meshed),
        section=section,
        material=read_material(table.table("material")),
        section_end=_section_end(table, section) if "section_end" in table.data else None,
    )


def _section_end(table: Table, start: Section) -> Section:
    """Read the section at the end of a taper: the shape at its start, and a section all the way."""
    end = read_section(table.table("section_end"))
    names = [type(section).__name__.lower() for section in (start, end)]
    if names[0] != names[1]:
        table.refuse(
            "section_end",
            "A taper cannot change the shape of its section.",
            f"section is a {names[0]}, section_end a {names[1]}",
            "only the dimensions of one shape run from one end to the other",
            f"give section_end the shape {names[0]}, or make two segments",
        )
    if isinstance(start, Polygon) and isinstance(end, Polygon):
        if len(start.points) != len(end.points):
            table.refuse(
                "section_end",
                "The polygons of a taper have different numbers of corners.",
                f"section has {len(start.points)}, section_end {len(end.points)}",
                "each corner runs straight to the corner of the same place in the other list",
                "give both the same number of corners, in the same order",
            )
        _check_polygons(table, start, end)
    return end


def _check_polygons(table: Table, start: Polygon, end: Polygon) -> None:
    """Refuse polygons between which the section folds, turns over or vanishes."""
    for fraction in np.linspace(0.0, 1.0, PLACES + 1)[1:-1]:
        problem = _fault(between(start, end, float(fraction)))
        if problem:
            table.refuse(
                "section_end",
                "The section breaks down along the taper.",
                f"at {fraction:.3g} of the segment it {problem}",
                "corners run straight to those of the same place in the other list, which is out of step",
                "let both lists begin at the same corner and run counter-clockwise",
            )


def _fault(section: Any) -> str:
    """What is wrong with a polygon; empty when nothing is."""
    points = np.array(section.points) - section.points[0]
    following = np.roll(points, -1, axis=0)
    area = 0.5 * float(np.sum(points[:, 0] * following[:, 1] - following[:, 0] * points[:, 1]))
    size = float(np.max(np.abs(points)))
    if size == 0.0 or area < 1e-12 * size**2:
        return "has no area, or runs clockwise"
    if crossing_edges(points / size):
        return "crosses or touches itself"
    if not thinness(section) >= THINNEST:
        return "is too thin to compute with"
    return ""
