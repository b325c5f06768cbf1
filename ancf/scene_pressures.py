"""Reading of the chambers under pressure that a scene lists."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ancf.scene import SAME_PLACE, Pressure, Rod
from ancf.scene_cable import refuse_on_cable
from ancf.scene_loads import rod_of
from ancf.scene_table import FRACTION, REQUIRED, Limit, Table
from ancf.sections import Annulus, Circle, Section
from ancf.units import LENGTH, NUMBER, STRESS

RADIUS = Limit(lambda v: v > 0.0, "> 0")
OUTLINE = 48  # points on the wall of a chamber that must lie in the section


def read_pressure(table: Table, rods: Sequence[Rod]) -> Pressure:
    """Read one `[[pressure]]`: its rod, its value and its chamber."""
    table.expect_keys(("rod", "value", "from", "to", "chamber"))
    rod = rod_of(table, rods, "the chamber lies in")
    why = "pressure acts on the walls and end caps of a chamber in the sections"
    refuse_on_cable(table, rod, "rod", "A cable has no chamber.", why)
    start, end = table.number("from", NUMBER, 0.0, FRACTION), table.number("to", NUMBER, 1.0, FRACTION)
    if end - start <= SAME_PLACE:
        table.refuse(
            "to",
            "The chamber has no length.",
            f"from = {start:g}, to = {end:g}",
            "both are fractions of the length, from below to",
            "exchange them, or leave both away for the whole rod",
        )
    chamber = table.table("chamber", REQUIRED)
    chamber.expect_keys(("centre", "radius"))
    centre = chamber.vector("centre", 2, LENGTH, (0.0, 0.0))
    radius = chamber.number("radius", LENGTH, limit=RADIUS)
    for at in (start, end, *(place for place in rod.ends if start < place < end)):
        section = rod.section_at(float(at))
        if not _holds(section, centre, radius):
            chamber.refuse(
                "radius",
                "The chamber is larger than the section.",
                f"radius {radius:g} m round ({centre[0]:g}, {centre[1]:g}) m at {at:g} of the length leaves "
                f"{type(section).__name__.lower()}, which reaches {section.outer_radius:.4g} m",
                "the radius is a diameter, or another unit",
                "make the chamber smaller or move it towards the axis",
            )
    return Pressure(rod.name, table.number("value", STRESS), centre, radius, start, end)


def _holds(section: Section, centre: np.ndarray, radius: float) -> bool:
    """Whether a chamber lies inside the outline of a section; the bore of a tube is inside."""
    filled = Circle(section.radius) if isinstance(section, Annulus) else section
    wall = centre + Circle(radius).outline(OUTLINE)
    return all(filled.contains(float(y), float(z)) for y, z in wall)
