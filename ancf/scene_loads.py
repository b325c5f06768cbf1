"""Reading of the effects a scene lists, and of `[solver]` and `[stability]`.

Vectors leave this module in SCS: what was given with ``frame = "body"`` is turned with the rod's base.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ancf.scene import (
    Force,
    Gravity,
    LineLoad,
    LineMoment,
    Magnet,
    Moment,
    Rod,
    SolverOptions,
    StabilityOptions,
)
from ancf.scene_cable import refuse_on_cable
from ancf.scene_table import FRACTION, Limit, Table
from ancf.units import (
    ACCELERATION,
    FLUX_DENSITY,
    FORCE,
    FORCE_PER_LENGTH,
    LENGTH,
    MOMENT,
    MOMENT_PER_LENGTH,
    NUMBER,
    TIME,
    Dimension,
)

MOST_STEPS = 1_000_000
MOST_MODES = 100
DIRECTIONS = ("fixed", "follower")
TOLERANCE = Limit(lambda v: 0.0 < v <= 1e-2, "inside (0, 1e-2]")
# Below, estimates meet the rounding of the shape; above, they are none.
ACCURACY = Limit(lambda v: 1e-8 <= v <= 0.1, "between 1e-8 and 0.1")
SECONDS = Limit(lambda v: v > 0.0, "> 0")


def read_moment(table: Table, rods: Sequence[Rod]) -> Moment:
    """Read one `[[moment]]`."""
    table.expect_keys(("rod", "at", "value", "frame", "direction", "definition"))
    rod = rod_of(table, rods)
    why = "a moment turns a section, and a cable has none"
    refuse_on_cable(table, rod, "rod", "A cable carries no [[moment]].", why)
    return Moment(
        rod=rod.name,
        at=table.number("at", NUMBER, 1.0, FRACTION),
        value=_value(table, rod, MOMENT),
        frame=_frame(table),
        direction=table.word("direction", DIRECTIONS, "fixed"),
        definition=table.word("definition", ("section", "vorticity"), "section"),
    )


def read_force(table: Table, rods: Sequence[Rod]) -> Force:
    """Read one `[[force]]`; its point of action is the axis or a point of the section."""
    table.expect_keys(("rod", "at", "offset", "value", "frame", "direction"))
    rod = rod_of(table, rods)
    at = table.number("at", NUMBER, 1.0, FRACTION)
    offset = table.vector("offset", 2, LENGTH, (0.0, 0.0))
    if any(offset):
        why = "a lever arm needs a section that turns"
        refuse_on_cable(table, rod, "offset", "A cable carries forces on its axis only.", why)
    section = rod.section_at(at)
    # The axis itself may be loaded in a hollow section too: a plug or a clamp carries it there.
    if any(offset) and not section.contains(*offset):
        table.refuse(
            "offset",
            "The force acts outside the section.",
            f"offset = [{offset[0]:g}, {offset[1]:g}] m is no point of {type(section).__name__.lower()},"
            f" which reaches {section.outer_radius:.4g} m",
            "offset is measured from the axis in metres, or the wrong rod is named",
            "move the point into the section, or replace the lever by a [[moment]]",
        )
    return Force(
        rod=rod.name,
        at=at,
        value=_value(table, rod, FORCE),
        frame=_frame(table),
        offset=offset,
        direction=_direction(table, rod),
    )


def read_line_load(table: Table, rods: Sequence[Rod]) -> LineLoad:
    """Read one `[[line_load]]`."""
    table.expect_keys(("rod", "value", "frame", "direction"))
    rod = rod_of(table, rods)
    return LineLoad(
        rod=rod.name,
        value=_value(table, rod, FORCE_PER_LENGTH),
        frame=_frame(table),
        direction=_direction(table, rod),
    )


def read_line_moment(table: Table, rods: Sequence[Rod]) -> LineMoment:
    """Read one `[[line_moment]]`."""
    table.expect_keys(("rod", "value", "frame", "direction"))
    rod = rod_of(table, rods)
    refuse_on_cable(table, rod, "rod", "A cable carries no moments.", "it has no sections to turn")
    return LineMoment(
        rod=rod.name,
        value=_value(table, rod, MOMENT_PER_LENGTH),
        frame=_frame(table),
        direction=table.word("direction", DIRECTIONS, "fixed"),
    )


def read_magnet(table: Table, rods: Sequence[Rod]) -> Magnet:
    """Read one `[[magnet]]`: remanence of the rod in its section axes, flux density of the field in SCS."""
    table.expect_keys(("rod", "remanence", "field"))
    rod = rod_of(table, rods)
    refuse_on_cable(table, rod, "rod", "A cable is no magnet.", "it has no sections that a couple could turn")
    remanence, field = (table.vector(key, 3, FLUX_DENSITY) for key in ("remanence", "field"))
    return Magnet(rod.name, remanence, field)


def read_gravity(table: Table, rods: Sequence[Rod], source: str) -> Gravity:
    """Read `[gravity]`; every rod then needs a density."""
    table.expect_keys(("acceleration",))
    acceleration = table.vector("acceleration", 3, ACCELERATION)
    for i, rod in enumerate(rods):
        for j, part in enumerate(rod.parts):
            if part.material.density is not None:
                continue
            place = f"rod[{i}].segments[{j}].material" if rod.segments else f"rod[{i}].material"
            Table({}, source, place).refuse(
                "density",
                "Gravity needs a density.",
                f'rod "{rod.name}" has none' + (" there" if rod.segments else ""),
                "the scene lists [gravity], which pulls on every rod",
                "add density = ... [kg/m^3] to its material, or remove [gravity]",
            )
    return Gravity(acceleration)


def read_solver(table: Table) -> SolverOptions:
    """Read `[solver]`; every key has a default."""
    known = (
        "tolerance",
        "accuracy",
        "tangent",
        "method",
        "predictor",
        "reduction",
        "max_steps",
        "max_seconds",
        "friction_steps",
    )
    table.expect_keys(known)
    defaults = SolverOptions()
    accuracy = table.number("accuracy", NUMBER, limit=ACCURACY) if "accuracy" in table.data else None
    return SolverOptions(
        tolerance=table.number("tolerance", NUMBER, defaults.tolerance, TOLERANCE),
        method=table.word("method", ("newton", "arclength"), defaults.method),
        tangent=table.word("tangent", ("analytic", "finite-difference"), defaults.tangent),
        predictor=table.word("predictor", ("auto", "none"), defaults.predictor),
        reduction=table.word("reduction", ("auto", "full", "planar"), defaults.reduction),
        max_steps=table.whole("max_steps", 1, MOST_STEPS, defaults.max_steps),
        max_seconds=table.number("max_seconds", TIME, defaults.max_seconds, SECONDS),
        friction_steps=table.whole("friction_steps", 1, MOST_STEPS, defaults.friction_steps),
        accuracy=accuracy,
    )


def read_stability(table: Table) -> StabilityOptions:
    """Read `[stability]`; every key has a default."""
    table.expect_keys(("modes", "branch"))
    defaults = StabilityOptions()
    return StabilityOptions(
        modes=table.whole("modes", 1, MOST_MODES, defaults.modes),
        branch=table.word("branch", ("primary", "buckled"), defaults.branch),
    )


def rod_of(table: Table, rods: Sequence[Rod], what: str = "the load stands on") -> Rod:
    """Return the rod a table names, by default the first; `what` is for the message."""
    names = [rod.name for rod in rods]
    name = table.known("rod", names, "rod", f"{what} a rod that the scene does not list")
    return rods[names.index(name)]


def _frame(table: Table) -> str:
    return table.word("frame", ("structure", "body"), "structure")


def _direction(table: Table, rod: Rod) -> str:
    """Read the direction of a force; a follower turns with a section."""
    direction = table.word("direction", DIRECTIONS, "fixed")
    if direction == "follower":
        why = "a follower turns with the section, and a cable has none"
        refuse_on_cable(table, rod, "direction", "A cable carries no follower loads.", why)
    return direction


def _value(table: Table, rod: Rod, dimension: Dimension) -> NDArray[np.float64]:
    """Read the vector (3,) of a load and return it in SCS: A_o value for ``frame = "body"`` (paper eq. 2)."""
    value = table.vector("value", 3, dimension)
    if _frame(table) == "body":
        with np.errstate(over="ignore"):
            value = rod.base.rotation @ value
        if not np.all(np.isfinite(value)):
            table.refuse(
                "value",
                "The load overflows when it is turned into SCS.",
                f"|value| > 1.8e308 {dimension.unit}",
                "all components are near the end of the number range",
                "give a smaller load",
            )
    return value
