"""From a scene file (TOML) or a dictionary to a validated `Scene`.

This is the border: whatever passes is finite, in SI units, in SCS, and has an equilibrium problem to solve.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ancf.added_effects import brought_tables, read_added
from ancf.errors import Message, SceneError
from ancf.mesh import distinct_places, held_places, places_in_part, rod_breaks
from ancf.scene import Rod, Scene, SolverOptions
from ancf.scene_contacts import check_options, read_contacts
from ancf.scene_effects import EFFECT_MODULES
from ancf.scene_joints import joined_rods, motion_as_joint, read_joints
from ancf.scene_loads import (
    read_force,
    read_gravity,
    read_line_load,
    read_line_moment,
    read_magnet,
    read_moment,
    read_solver,
    read_stability,
)
from ancf.scene_pressures import read_pressure
from ancf.scene_rods import default_name, read_rod
from ancf.scene_springs import read_foundation, read_spring
from ancf.scene_table import Table
from ancf.scene_tendons import read_tendon

SCENE_KEYS = ("title", "rod", *EFFECT_MODULES.values(), "joint", "motion", "solver", "stability")
LARGEST_FILE = 10_000_000  # bytes; a scene is a page of text, so more is another file


def load_scene(path: str | PathLike[str]) -> Scene:
    """Read and check a scene file.

    Parameters
    ----------
    path : path of a TOML file in the format of the README

    Returns
    -------
    Scene
        Records in SI units and SCS.

    Raises
    ------
    SceneError
        If the file cannot be read, is no TOML, or says something that cannot be simulated.
    """
    return scene_from_dict(read_tables(path), str(path))


def read_tables(path: str | PathLike[str]) -> dict[str, Any]:
    """The tables of a TOML file as they stand there; raises `SceneError` where it cannot be read."""
    text = _read_text(path)
    source = str(path)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = re.fullmatch(r"(.*) \(at (.*)\)", str(error), re.DOTALL)
        what, place = (found[1], found[2]) if found else (str(error), "")
        raise SceneError(
            Message(
                "The scene file is not valid TOML.",
                f"{source}: {place}" if place else source,
                what,
                "a missing quote, bracket, comma or equals sign, or a key or table given twice",
                "correct that line; keys stand left of =, texts in quotes, lists in brackets",
            )
        ) from None
    except (ValueError, RecursionError) as error:
        raise SceneError(
            Message(
                "The scene file cannot be parsed.",
                source,
                str(error) or type(error).__name__,
                "a number of thousands of digits, or brackets nested hundreds deep",
                "check that this is a scene file",
            )
        ) from None


def scene_from_dict(data: Mapping[str, Any], where: str = "scene") -> Scene:
    """Check a dictionary of the scene format and return it as a `Scene`.

    Parameters
    ----------
    data : the tables of a scene file; lists may be tuples or arrays
    where : name of the source, for messages

    Raises
    ------
    SceneError
        As `load_scene`.
    """
    table = Table(data, where)
    brought = brought_tables(table, SCENE_KEYS)
    table.expect_keys((*SCENE_KEYS, *brought))
    entries = table.tables("rod")
    if not entries:
        table.refuse(
            "rod",
            "The scene has no rod.",
            "no [[rod]] table",
            "a scene needs at least one rod to simulate",
            "add a [[rod]] table with length, elements, section and material, or with segments",
        )
    joined = joined_rods(data, [str(entry.data.get("name", default_name(0))) for entry in entries[:1]])
    solver = read_solver(table.table("solver")) if "solver" in table.data else SolverOptions()
    meshed = solver.accuracy is None
    rods = tuple(read_rod(entry, index, joined, meshed) for index, entry in enumerate(entries))
    _check_names(entries, rods)
    scene = Scene(
        rods=rods,
        moments=tuple(read_moment(entry, rods) for entry in table.tables("moment")),
        forces=tuple(read_force(entry, rods) for entry in table.tables("force")),
        line_loads=tuple(read_line_load(entry, rods) for entry in table.tables("line_load")),
        line_moments=tuple(read_line_moment(entry, rods) for entry in table.tables("line_moment")),
        magnets=tuple(read_magnet(entry, rods) for entry in table.tables("magnet")),
        gravity=read_gravity(table.table("gravity"), rods, where) if "gravity" in table.data else None,
        tendons=tuple(read_tendon(entry, rods) for entry in table.tables("tendon")),
        pressures=tuple(read_pressure(entry, rods) for entry in table.tables("pressure")),
        springs=tuple(read_spring(entry, rods) for entry in table.tables("spring")),
        foundations=tuple(read_foundation(entry, rods) for entry in table.tables("foundation")),
        contacts=read_contacts(table, rods),
        added=read_added(table, brought, rods),
        joints=read_joints(
            [*table.tables("joint"), *(motion_as_joint(entry) for entry in table.tables("motion"))],
            entries,
            rods,
        ),
        solver=solver,
        stability=read_stability(table.table("stability")) if "stability" in table.data else None,
        title=table.text("title", ""),
    )
    for entry, rod in zip(entries, rods if meshed else (), strict=meshed):
        _check_pieces(entry, rod, held_places(scene, rod))
        _check_turn(entry, rod, float(np.diff(rod_breaks(scene, rod)).max()))
    check_options(table, scene)
    if scene.constrained and scene.solver.tangent == "finite-difference":
        thing, key = ("Joints", "[[joint]]") if scene.joints else ("Tendons of given length", "[[tendon]]")
        table.refuse(
            "solver.tangent",
            f"{thing} have no finite-difference tangent.",
            f'tangent = "finite-difference" with {key}',
            "the paper's tangent is for rods; conditions on their motion know their exact one only",
            'write tangent = "analytic", or leave the key away',
        )
    if scene.solver.reduction == "planar":
        from ancf.reductions import chosen

        chosen(scene, where)
    return scene


def _read_text(path: str | PathLike[str]) -> str:
    """Read a scene file as UTF-8 text; a byte-order mark is dropped."""
    source = str(path)
    try:
        with Path(path).open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
        if len(content) > LARGEST_FILE:
            raise ValueError(f"it is larger than {LARGEST_FILE // 1_000_000} MB")
        return content.decode("utf-8-sig")
    except IsADirectoryError:
        reason, cause, advice = "it is a directory", "a folder was named", "name the .toml file inside it"
    except FileNotFoundError:
        reason, cause, advice = "no such file", "a misspelt path", f"check the path from {Path.cwd()}"
    except UnicodeDecodeError as error:
        reason = f"byte {error.start} is not UTF-8"
        cause, advice = "another encoding, or no text file at all", "save the file as UTF-8"
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        cause, advice = "the system refuses to read it", "check path, permissions and size"
    raise SceneError(Message("The scene file cannot be read.", source, reason, cause, advice))


def _check_names(entries: Sequence[Table], rods: Sequence[Rod]) -> None:
    """Refuse two rods of one name: loads and results go by name."""
    names = [rod.name for rod in rods]
    for i, name in enumerate(names):
        if name in names[:i]:
            entries[i].refuse(
                "name",
                f'Two rods are named "{name}".',
                f"rod[{names.index(name)}] has the same name",
                "a copied table, or a name that is another rod's default",
                "give each rod its own name",
            )


def _check_pieces(entry: Table, rod: Rod, held: list[float]) -> None:
    """Refuse fewer elements than there are pieces between supports and joints: each needs a boundary."""
    for part, segment in enumerate(rod.parts):
        pieces = len(distinct_places(places_in_part(rod, part, held))) - 1
        if pieces > segment.elements:
            entry.refuse(
                f"segments[{part}].elements" if rod.segments else "elements",
                "There are fewer elements than pieces between supports and joints.",
                f"elements = {segment.elements}, pieces = {pieces}",
                "every support and joint stands on an element boundary",
                f"take elements >= {pieces}",
            )


def _check_turn(entry: Table, rod: Rod, longest: float) -> None:
    """Refuse a reference whose longest element turns by more than a quarter turn."""
    angle = float(np.linalg.norm(rod.curvature)) * longest
    if angle > math.pi / 2:
        entry.refuse(
            "curvature",
            "The elements are too long for this curvature.",
            f"one element turns by {math.degrees(angle):.4g} degrees, must be <= 90",
            "an element cannot follow more than a quarter turn",
            f"take elements >= {math.ceil(2.0 * angle * rod.elements / math.pi):g}, or reduce the curvature",
        )
