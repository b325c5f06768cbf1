"""Reading of the contacts that a scene lists."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ancf.obstacles import Cylinder, Obstacle, Plane, Sphere
from ancf.scene import Contact, Rod, Scene
from ancf.scene_rods import read_direction
from ancf.scene_table import REQUIRED, SIGNED, Limit, Table
from ancf.sections import Annulus, Circle
from ancf.units import LENGTH, NUMBER

RADIUS = Limit(lambda v: 1e-20 <= v <= 1e20, "> 0")
NOT_NEGATIVE = Limit(lambda v: v >= 0.0, ">= 0")
# Keys of each shape beside `shape`.
SHAPES = {
    "plane": ("point", "normal"),
    "sphere": ("centre", "radius"),
    "cylinder": ("point", "axis", "radius"),
}


def read_contacts(table: Table, rods: Sequence[Rod]) -> tuple[Contact, ...]:
    """Read the `[[contact]]` tables: of each its rod and the obstacle."""
    return tuple(_read_contact(entry, rods) for entry in table.tables("contact"))


def lying_rods(data: Mapping[Any, Any], first: str) -> set[str]:
    """Rods that contacts with friction in the raw scene name, unchecked: it may hold them."""
    contacts = data.get("contact", ())
    contacts = contacts if isinstance(contacts, list | tuple) else ()
    return {str(c.get("rod", first)) for c in contacts if isinstance(c, Mapping) and c.get("friction")}


def _read_contact(table: Table, rods: Sequence[Rod]) -> Contact:
    table.expect_keys(("rod", "with", "friction"))
    names = [rod.name for rod in rods]
    name = table.known("rod", names, "rod", "the contact is of a rod that the scene does not list")
    friction = table.number("friction", NUMBER, 0.0, NOT_NEGATIVE)
    _check_round(table, rods[names.index(name)])
    body = table.table("with", REQUIRED)
    if body.word("shape", (*SHAPES, "rod")) != "rod":
        return Contact(name, _read_obstacle(body), friction=friction)
    body.expect_keys(("shape", "name"))
    body.get("name", REQUIRED)
    other = body.known("name", names, "rod", "the contact is with a rod that the scene does not list")
    _check_round(body, rods[names.index(other)])
    return Contact(name, other=other, friction=friction)


def _read_obstacle(table: Table) -> Obstacle:
    shape = table.word("shape", tuple(SHAPES))
    table.expect_keys(("shape", *SHAPES[shape]))
    if shape == "plane":
        return Plane(
            table.vector("point", 3, LENGTH, limit=SIGNED), read_direction(table, "normal", REQUIRED)
        )
    if shape == "sphere":
        return Sphere(
            table.vector("centre", 3, LENGTH, limit=SIGNED), table.number("radius", LENGTH, limit=RADIUS)
        )
    radius = table.number("radius", LENGTH, limit=RADIUS)
    return Cylinder(
        table.vector("point", 3, LENGTH, limit=SIGNED), read_direction(table, "axis", REQUIRED), radius
    )


def _check_round(table: Table, rod: Rod) -> None:
    """Refuse sections that are no circles: their surface is not at one distance from the axis."""
    for part in rod.parts:
        for section in (part.section, part.last_section):
            if not isinstance(section, Circle | Annulus):
                table.refuse(
                    "rod" if "with" in table.data else "name",
                    "Contact knows round sections only.",
                    f'rod "{rod.name}" has a section {type(section).__name__.lower()}',
                    "the gap is the distance of the axis less the radius of the section",
                    'take shape = "circle" or "annulus" for this rod, or remove the contact',
                )


def check_options(table: Table, scene: Scene) -> None:
    """Refuse options that contact does not serve in this version."""
    if not scene.contacts:
        return
    now = "contact in load steps on a given mesh"
    if scene.solver.accuracy is not None:
        table.refuse_later("solver.accuracy", "Contact with `accuracy`", now)
    if scene.solver.method != "newton":
        table.refuse_later("solver.method", f'Contact with method = "{scene.solver.method}"', now)
    if scene.stability is not None:
        table.refuse_later("stability", "Contact with [stability]", now)
