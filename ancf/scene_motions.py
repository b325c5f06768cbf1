r"""Reading of `[[motion]]` tables: the prescribed motion of a section, whole or of single components.

A motion is a joint of the section with the ground. `hold` says of what: "pose", "position", or a list of
components, displacements x, y, z and rotations rx, ry, rz along and about the axes of `frame`. The others are
free and carry nothing: a roller holds ["y"], a sliding clamp ["y", "z", "rx", "ry", "rz"]. Of the rotations

    three   R = Exp(phi);                                                           "rigid"
    two     R = Exp(phi) Exp(a n), n the free axis, a free: it turns along;         "hinge"
    one     the twist of R about its axis n is phi . n, its swing free;             "twist"
    none                                                                            "ball"

with R the rotation of the section and phi the prescribed rotation vector. Any rotation is a swing, about an
axis across n, times a twist about n, in either order with the same angle 2 atan2(v . n, w) of the unit
quaternion (w, v); a swing of half a turn has none.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ancf.scene import Joint, Place, Rod
from ancf.scene_cable import refuse_on_cable
from ancf.scene_table import FRACTION, SIGNED, Table, nearest, show
from ancf.units import LENGTH, NUMBER, Dimension

Floats = NDArray[np.float64]

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
WORDS = {"pose": COMPONENTS, "position": COMPONENTS[:3]}
KINDS = ("ball", "twist", "hinge", "rigid")  # by the number of rotations held


def read_motion(table: Table, rods: Sequence[Rod]) -> Joint:
    """Read one `[[motion]]` as the joint with the ground that prescribes it."""
    table.expect_keys(("rod", "at", "hold", "frame", "displacement", "rotation"))
    listed = not isinstance(table.data.get("hold", ""), str)
    hold = _components(table) if listed else WORDS[table.word("hold", tuple(WORDS), "pose")]
    if not listed and not {"displacement", "rotation"} & set(table.data):
        table.refuse(
            "displacement",
            "The motion moves nothing.",
            "neither displacement nor rotation",
            "a section that is only held is a support or a joint",
            'add displacement = [x, y, z], list what a roller holds (hold = ["y"]), or use supports',
        )
    if "rotation" in table.data and not set(hold) & set(COMPONENTS[3:]):
        table.refuse(
            "rotation",
            "The rotation is given and left free.",
            f"rotation = {show(table.data['rotation'])} with hold = {show(table.data['hold'])}",
            "a section that is held by its position alone turns as it likes",
            'write hold = "pose" or list rx, ry or rz there, or remove rotation',
        )
    names = [rod.name for rod in rods]
    name = table.known("rod", names, "rod", "the motion is of a rod that the scene does not list")
    rod = rods[names.index(name)]
    refuse_on_cable(table, rod, "rod", "No motion holds a cable.", "a section is moved, and a cable has none")
    body = table.word("frame", ("structure", "body"), "structure") == "body"
    axes = rod.base.rotation if body else np.eye(3)
    displacement = _moved(table, "displacement", LENGTH, hold, COMPONENTS[:3])
    rotation = _moved(table, "rotation", NUMBER, hold, COMPONENTS[3:])
    slides = [i for i, one in enumerate(COMPONENTS[:3]) if one in hold]
    turns = [i for i, one in enumerate(COMPONENTS[3:]) if one in hold]
    # The axis of a hinge is the one left free, of a twist the one held.
    free = next((i for i in range(3) if i not in turns), 2)
    return Joint(
        KINDS[len(turns)],
        Place(name, table.number("at", NUMBER, 1.0, FRACTION)),
        None,
        axes[:, turns[0] if len(turns) == 1 else free],
        axes @ displacement,
        axes @ rotation,
        along=axes[:, slides].T if len(slides) < 3 else np.eye(3),
        hold=hold if listed else (),
    )


def _components(table: Table) -> tuple[str, ...]:
    """The components that `hold` lists, in the order of `COMPONENTS`."""
    given = table.items("hold", (), f"a list of {', '.join(COMPONENTS)}, or a word")
    for index, one in enumerate(given):
        if one not in COMPONENTS:
            close = nearest(one, COMPONENTS) if isinstance(one, str) else None
            table.refuse(
                f"hold[{index}]",
                f"Unknown component {show(one)}.",
                f"{show(one)} is none of {', '.join(COMPONENTS)}",
                "x, y, z are displacements along the axes, rx, ry, rz rotations about them",
                f'did you mean "{close}"?' if close else 'write for example hold = ["y", "rz"]',
            )
    if not given or len(set(given)) < len(given):
        table.refuse(
            "hold",
            "The motion holds nothing." if not given else "The motion holds a component twice.",
            f"hold = {show(given)}",
            "an empty list" if not given else "a copied entry",
            'list each component once, for example hold = ["y"] for a roller',
        )
    return tuple(one for one in COMPONENTS if one in given)


def _moved(table: Table, key: str, dimension: Dimension, hold: Sequence[str], names: Sequence[str]) -> Floats:
    """A vector (3,) in the axes of the motion that is zero in what it leaves free."""
    value = table.vector(key, 3, dimension, (0.0, 0.0, 0.0), SIGNED)
    for index, name in enumerate(names):
        if value[index] != 0.0 and name not in hold:
            table.refuse(
                f"{key}[{index}]",
                "The motion moves what it leaves free.",
                f"{key}[{index}] = {value[index]:g}, and hold = {show(list(hold))}",
                f'the component "{name}" is not among those that are held',
                f'add "{name}" to hold, or write 0 there',
            )
    return value
