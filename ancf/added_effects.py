"""Effects that other packages bring, as entry points of the group ``ancf.effects``.

An entry point has the name of its table in scene files, and names a module (or another object) with

    read(table, rods) -> record                     one table, checked; rods are the scene's `Rod` records
    build(scene, rods, records) -> list[Effect]     rods are the `RodModel`s; called for every model

A record is a frozen dataclass of numbers in SI units. `read` uses the methods of `scene_table.Table`, so what
it refuses ends as any other message. Entry points are looked up only for a table that this package does not
know, and a module is imported only if a scene has its table.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ancf.scene import AddedEffect, Rod, Scene
from ancf.scene_table import Table

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from ancf.effects import Effect
    from ancf.rod_model import RodModel

GROUP = "ancf.effects"


def brought_tables(table: Table, known: Sequence[str]) -> dict[str, EntryPoint]:
    """Entry points by the name of their table; none are looked up if the scene has only tables in `known`."""
    if all(key in known for key in table.data):
        return {}
    from importlib.metadata import entry_points

    found: dict[str, EntryPoint] = {}
    for point in entry_points(group=GROUP):
        if point.name in known:
            continue
        other = found.setdefault(point.name, point)
        if other.value != point.value and point.name in table.data:
            table.refuse(
                point.name,
                f'Two packages bring the effect "{point.name}".',
                f"{other.value} and {point.value}",
                f"both are entry points of the group {GROUP}",
                "uninstall one of them",
            )
    return found


def read_added(
    table: Table, brought: Mapping[str, EntryPoint], rods: Sequence[Rod]
) -> tuple[AddedEffect, ...]:
    """Records of the tables of a scene that other packages know; a single [table] is a list of one."""
    found = []
    for name, point in brought.items():
        if name not in table.data:
            continue
        single = isinstance(table.data[name], Mapping)
        entries = [table.table(name)] if single else table.tables(name)
        module = _loaded(table, point)
        found.append(AddedEffect(name, point.value, tuple(module.read(entry, rods) for entry in entries)))
    return tuple(found)


def build_added(added: AddedEffect, scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Effects of the records of one table; they are counted under its name."""
    effects = _resolved(added.source).build(scene, rods, added.records)
    for effect in effects:
        effect.name = added.table
    return effects


def _resolved(source: str) -> Any:
    """The object of an entry point, "package.module" or "package.module:name"."""
    return pkgutil.resolve_name(source)


def _loaded(table: Table, point: EntryPoint) -> Any:
    """The object of an entry point; refuses the scene if it cannot be had."""
    try:
        module = _resolved(point.value)
        missing = [name for name in ("read", "build") if not callable(getattr(module, name, None))]
        reason = f"it has no {' and no '.join(missing)}" if missing else ""
    except Exception as error:  # another package may fail in any way
        module, reason = None, f"{type(error).__name__}: {error}"
    if reason:
        package = "" if point.dist is None else f" of {point.dist.name} {point.dist.version}"
        table.refuse(
            point.name,
            f'The effect "{point.name}" cannot be loaded.',
            f"{point.value}{package}: {reason}",
            "the package that brings it is broken, or made for another version",
            "install it again, or remove the table",
        )
    return module
