"""Reading of the tendons that a scene lists."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ancf.scene import SAME_PLACE, Rod, Tendon
from ancf.scene_cable import refuse_on_cable
from ancf.scene_loads import rod_of
from ancf.scene_table import FRACTION, REQUIRED, Limit, Table
from ancf.sections import Annulus
from ancf.units import FORCE, LENGTH, NUMBER

TENSION = Limit(lambda v: v >= 0.0, ">= 0: tendons pull")
FRICTION = Limit(lambda v: v >= 0.0, ">= 0: friction takes from the tension")
WANTED = Limit(lambda v: v > 0.0, "> 0")


def read_tendon(table: Table, rods: Sequence[Rod]) -> Tendon:
    """Read one `[[tendon]]`: the rod it runs in, its tension or length, its path inside the sections."""
    table.expect_keys(("rod", "tension", "length", "path", "friction"))
    rod = rod_of(table, rods, "the tendon runs in")
    why = "a tendon needs sections that hold it off the axis"
    refuse_on_cable(table, rod, "rod", "A tendon cannot run in a cable.", why)
    given = [key for key in ("tension", "length") if key in table.data]
    if len(given) != 1:
        table.refuse(
            "tension" if not given else "length",
            "The tendon has both a tension and a length." if given else "Nothing pulls the tendon.",
            "tension and length" if given else "neither tension nor length",
            "a tendon is pulled by a tension, or its drive holds it at a length with the tension that takes",
            'write one of the two, for example tension = "2 N" or length = "38 cm"',
        )
    return Tendon(
        rod.name,
        table.number("tension", FORCE, limit=TENSION) if given == ["tension"] else None,
        _path(table, rod),
        table.number("length", LENGTH, limit=WANTED) if given == ["length"] else None,
        table.number("friction", NUMBER, 0.0, FRICTION),
    )


def _path(table: Table, rod: Rod) -> NDArray[np.float64]:
    """Points (n, 3) of [at, y, z], rising along the rod and inside it."""
    entries = table.items("path", REQUIRED, "a list of points [at, y, z]")
    points = np.array([_point(table, entry, index) for index, entry in enumerate(entries)]).reshape(-1, 3)
    if len(points) < 2 or np.any(np.diff(points[:, 0]) <= SAME_PLACE):
        table.refuse(
            "path",
            "The path of the tendon does not run along the rod.",
            f"at = {points[:, 0].tolist()}, must rise from one point to the next",
            "a tendon is given by two or more points from its base to its end",
            "order the points by at; a second way back is a second [[tendon]]",
        )
    for index, (at, y, z) in enumerate(points):
        section = rod.section_at(float(at))
        in_bore = isinstance(section, Annulus) and np.hypot(y, z) < section.radius  # held by discs in there
        if not (in_bore or section.contains(float(y), float(z))):
            table.refuse(
                f"path[{index}]",
                "The tendon leaves the section.",
                f"(y, z) = ({y:g}, {z:g}) m at {at:g} is no point of {type(section).__name__.lower()}, "
                f"which reaches {section.outer_radius:.4g} m",
                "y and z are measured from the axis in metres; discs around a thin rod are not modelled",
                "move the tendon into the section, or describe the rod by the section that holds it",
            )
    return points


def _point(table: Table, entry: object, index: int) -> list[float]:
    """One point [at, y, z]."""
    if isinstance(entry, np.ndarray):
        entry = entry.tolist()
    key = f"path[{index}]"
    if not isinstance(entry, list | tuple) or len(entry) != 3:
        table.refuse(
            key,
            "A point of the tendon's path is no triple.",
            f"{entry!r}; [at, y, z] is needed",
            "at is a fraction of the length, y and z are metres in the section",
            "write for example [0.0, 0.006, 0.0]",
        )
    at, y, z = entry
    return [
        table.to_number(at, f"{key}[0]", NUMBER, FRACTION),
        table.to_number(y, f"{key}[1]", LENGTH),
        table.to_number(z, f"{key}[2]", LENGTH),
    ]
