"""Designs of data sets: a scene, the components of its loads that vary, and how they are sampled.

A design is a scene file with one more table, [design]; the presets are such files in `designs/`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.errors import InputError, Message
from ancf.scene import Scene
from ancf.scene_file import read_tables, scene_from_dict
from ancf.scene_table import Table, nearest
from ancf.units import FORCE, MOMENT, Dimension

Floats = NDArray[np.float64]

PRESETS = ("sobol", "paper")
SAMPLINGS = ("sobol", "grid", "random")
SPLITS = ("random", "design")
MOST_ROWS = 100_000_000  # a table of loads that still fits into memory
KINDS: dict[str, Dimension] = {"moment": MOMENT, "force": FORCE, "tendon": FORCE}
COMPONENTS = ("x", "y", "z")
DESIGN_KEYS = ("sampling", "count", "seed", "split", "vary")
VARY_KEYS = ("load", "index", "component", "range", "steps")


@dataclass(frozen=True)
class Variable:
    """One component of one load and the range in which it varies."""

    load: str  # moment | force | tendon
    index: int  # which of the scene's loads of that kind
    component: str  # x, y or z in the frame of the load; "tension" of a tendon
    low: float  # N m or N
    high: float
    steps: int = 0  # levels of a grid, both ends included

    @property
    def name(self) -> str:
        """For example ``moment[0].x``."""
        return f"{self.load}[{self.index}].{self.component}"

    @property
    def unit(self) -> str:
        """N m for a moment, else N."""
        return KINDS[self.load].unit


@dataclass(frozen=True, eq=False)
class Design:
    """What is solved: a scene in the format of a scene file, its variables and their sampling."""

    tables: Mapping[str, Any]  # the whole design as it was read, [design] included
    scene: Scene
    variables: tuple[Variable, ...]
    sampling: str
    count: int
    seed: int
    split: str

    @property
    def name(self) -> str:
        """The title."""
        return self.scene.title or "untitled"

    @cached_property
    def bounds(self) -> Floats:
        """Bounds (k, 2) of the variables."""
        return np.array([[variable.low, variable.high] for variable in self.variables])

    def still(self, kind: str) -> Floats:
        """Values (loads, 3) of the scene's moments or forces, each in its own frame."""
        loads = self.scene.moments if kind == "moment" else self.scene.forces
        # A scene holds them in SCS.
        return np.array([self.scene.load_axes(load).T @ load.value for load in loads]).reshape(-1, 3)

    def first_moments(self, points: Floats) -> Floats:
        """Values (n, 3) [N m] of the first moment in its frame; zero where the scene has none."""
        loads = self.values(points)
        if "moments" in loads:
            return loads["moments"][:, 0]
        own = self.still("moment")
        return np.tile(own[0] if len(own) else np.zeros(3), (len(points), 1))

    def values(self, points: Floats) -> dict[str, Floats]:
        """Loads of all rows as `ancf.solve_batch` takes them, from the values (n, k) of the variables.

        Returns
        -------
        ``moments`` and ``forces`` (n, loads, 3) in their frames, ``tensions`` (n, tendons); only kinds of
        which something varies.
        """
        varied = {variable.load for variable in self.variables}
        found = {
            f"{kind}s": np.tile(self.still(kind), (len(points), 1, 1))
            for kind in ("moment", "force")
            if kind in varied
        }
        if "tendon" in varied:
            found["tensions"] = np.tile([t.tension for t in self.scene.tendons], (len(points), 1))
        for variable, column in zip(self.variables, points.T, strict=True):
            if variable.load == "tendon":
                found["tensions"][:, variable.index] = column
            else:
                axis = COMPONENTS.index(variable.component)
                found[f"{variable.load}s"][:, variable.index, axis] = column
        return found


def load_design(path: str | PathLike[str]) -> Design:
    """Read a design file; raises `SceneError` as `ancf.load_scene` does."""
    return design_from_dict(read_tables(path), str(path))


def preset(name: str, count: int | None = None, seed: int | None = None) -> Design:
    """One of the `PRESETS`, with another number of rows or another seed if wanted; raises `InputError`."""
    if name not in PRESETS:
        close = nearest(name, PRESETS)
        raise InputError(
            Message(
                "There is no such preset.", f"--preset {name}", f"presets are {', '.join(PRESETS)}",
                "a misspelt name" if close else "designs of your own are files: ancf dataset DESIGN.toml",
                f'did you mean "{close}"?' if close else f'take "{PRESETS[0]}"',
            )
        )  # fmt: skip
    tables = read_tables(Path(__file__).parent / "designs" / f"{name}.toml")
    return changed(tables, f"preset {name}", count, seed)


def changed(tables: Mapping[str, Any], where: str, count: int | None, seed: int | None) -> Design:
    """A design with another number of rows or another seed."""
    new = {key: value for key, value in (("count", count), ("seed", seed)) if value is not None}
    design = tables.get("design")
    if new and isinstance(design, Mapping):
        tables = {**tables, "design": {**design, **new}}
    return design_from_dict(tables, where)


def design_from_dict(tables: Mapping[str, Any], where: str = "design") -> Design:
    """Check a dictionary of the design format: a scene and the table [design].

    Raises
    ------
    SceneError : the scene or the design cannot be used, with file and key.
    """
    whole = Table(tables, where)
    scene = scene_from_dict({key: value for key, value in whole.data.items() if key != "design"}, where)
    if scene.solver.accuracy is not None:
        whole.table("solver").refuse(
            "accuracy",
            "A data set needs one mesh for all of its rows.",
            f"accuracy = {scene.solver.accuracy:g}",
            "the mesh would follow from the largest loads of each block of rows",
            "give element and elements instead; `ancf cost` says which",
        )
    table = whole.table("design")
    table.expect_keys(DESIGN_KEYS)
    sampling = table.word("sampling", SAMPLINGS, "sobol")
    variables = tuple(_variable(entry, scene, sampling) for entry in table.tables("vary"))
    if not variables:
        table.refuse(
            "vary", "Nothing varies in this design.", "no entry in vary",
            "a data set needs at least one load that varies",
            'add vary = [{ load = "moment", component = "x", range = [-0.01, 0.01] }]',
        )  # fmt: skip
    _check_twice(table, variables)
    if sampling == "grid":
        count = int(np.prod([float(variable.steps) for variable in variables]))
        if count > MOST_ROWS:
            table.refuse(
                "vary", "The grid is too large.", f"{count:g} rows, at most {MOST_ROWS:g}",
                "a grid has the product of its steps", 'fewer steps, or sampling = "sobol"',
            )  # fmt: skip
        if "count" in table.data and table.data["count"] != count:
            table.refuse(
                "count", "The number of rows does not belong to this grid.",
                f"count = {table.data['count']}, the steps give {count}",
                "a grid has the product of its steps",
                "leave count out, or change the steps",
            )  # fmt: skip
    else:
        count = table.whole("count", 1, MOST_ROWS)
    split = table.word("split", SPLITS, "design" if sampling == "sobol" else "random")
    if split == "design" and sampling == "grid":
        table.refuse(
            "split", "A grid has no independent designs.", 'split = "design"',
            "training, validation and test rows would be three equal grids", 'write split = "random"',
        )  # fmt: skip
    seed = table.whole("seed", 0, 2**63 - 1, 0)
    plain = json.loads(json.dumps(dict(whole.data), default=_plain))
    return Design(plain, scene, variables, sampling, count, seed, split)


def _variable(entry: Table, scene: Scene, sampling: str) -> Variable:
    entry.expect_keys(VARY_KEYS)
    kind = entry.word("load", tuple(KINDS))
    loads = {"moment": scene.moments, "force": scene.forces, "tendon": scene.tendons}[kind]
    if not loads:
        entry.refuse(
            "load", f"The scene has no {kind}.", f"no [[{kind}]] table",
            "a variable is a component of a load that the scene lists",
            f"add a [[{kind}]] table, of value zero if you like" if kind != "tendon" else "add a [[tendon]]",
        )  # fmt: skip
    index = entry.whole("index", 0, len(loads) - 1, 0)
    choices = ("tension",) if kind == "tendon" else COMPONENTS
    component = entry.word("component", choices, "tension" if kind == "tendon" else choices[0])
    low, high = (float(value) for value in entry.vector("range", 2, KINDS[kind]))
    lowest = 0.0 if kind == "tendon" else -np.inf
    if not lowest <= low < high:
        entry.refuse(
            "range", "The range is not one.", f"[{low:g}, {high:g}]",
            "the smaller number comes first" + (", and a tendon cannot push" if kind == "tendon" else ""),
            "give [smallest, largest]",
        )  # fmt: skip
    steps = entry.whole("steps", 2, MOST_ROWS) if sampling == "grid" else 0
    if sampling != "grid" and "steps" in entry.data:
        entry.refuse(
            "steps", "Only a grid has steps.", f'sampling = "{sampling}"',
            "count says how many rows there are", 'remove steps, or write sampling = "grid"',
        )  # fmt: skip
    return Variable(kind, index, component, low, high, steps)


def _check_twice(table: Table, variables: tuple[Variable, ...]) -> None:
    names = [variable.name for variable in variables]
    twice = next((name for i, name in enumerate(names) if name in names[:i]), None)
    if twice is not None:
        table.refuse(
            "vary", f"{twice} varies twice.", f"{names.count(twice)} entries for {twice}",
            "a copied entry", "keep one of them",
        )  # fmt: skip


def _plain(value: Any) -> Any:
    """Arrays and NumPy numbers as plain ones; anything else that TOML knows as text."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
