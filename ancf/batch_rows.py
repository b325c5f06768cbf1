"""The rows of a batch: values of a scene's loads, one row a sample, and what Newton finds for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancf.errors import refuse
from ancf.model import Model
from ancf.scene import Force, Moment, Scene, Tendon

Floats = NDArray[np.float64]

LOADS = ("moments", "forces", "tensions", "lengths")


@dataclass(frozen=True, eq=False)
class BatchLoads:
    """Values in SCS of all moments, forces, tensions and tendon lengths of a scene, a row for each sample.

    `scene` has loads of the largest row in place of its own: a load that acts in some rows has a node in all.
    """

    scene: Scene
    moments: Floats  # (B, moments of the scene, 3) N m
    forces: Floats  # (B, forces of the scene, 3) N
    tensions: Floats  # (B, tendons of given tension) N
    lengths: Floats  # (B, tendons of controlled length) m

    def __len__(self) -> int:
        return len(self.moments)

    def row(self, index: int) -> Scene:
        """The scene of one row."""
        return _with_values(self.scene, **{name: getattr(self, name)[index] for name in LOADS})

    def under(self, model: Model, index: int) -> Model:
        """The model of one row; `model` is that of `scene`."""
        return model.under(self.row(index))

    def taken(self, rows: NDArray[np.intp]) -> BatchLoads:
        """Some of the rows."""
        parts = {name: getattr(self, name)[rows] for name in LOADS}
        return replace(self, **parts)

    @cached_property
    def dimensionless(self) -> Floats:
        """All values of a row as one vector (B, k): moments by E I/L, forces by E I/L^2.

        Tensions act as moments, on a lever of the section's size.
        """
        moments = [self._unit(m) for m in self.scene.moments]
        forces = [self._unit(f) / self.scene.rod(f.rod).length for f in self.scene.forces]
        pulled = self.scene.pulled_tendons
        tendons = [self._unit(t) / self.scene.rod(t.rod).section.outer_radius for t in pulled]
        return np.concatenate(
            [
                self.tensions / np.array(tendons),
                (self.moments / np.reshape(moments, (-1, 1))).reshape(len(self), -1),
                (self.forces / np.reshape(forces, (-1, 1))).reshape(len(self), -1),
            ],
            axis=1,
        )

    def _unit(self, load: Moment | Force | Tendon) -> float:
        rod = self.scene.rod(load.rod)
        part = rod.parts[0]
        return part.material.young_modulus * part.section.weaker_second_moment / rod.length


@dataclass(frozen=True, eq=False)
class RowsResult:
    """What Newton found for each row; a row without an equilibrium never spoils the others."""

    q: Floats  # (B, n) last iterates, finite
    converged: NDArray[np.bool_]  # (B,) an equilibrium that may be taken: not collapsed, not unstable
    residual: Floats  # (B,) inf where a row did not get that far
    floor: Floats  # (B,)
    iterations: NDArray[np.int64]  # (B,) linear solves

    @classmethod
    def empty(cls, rows: int, n: int) -> RowsResult:
        """Of rows that are not solved yet."""
        residual, floor = np.zeros((2, rows))
        return cls(np.zeros((rows, n)), np.zeros(rows, bool), residual, floor, np.zeros(rows, np.int64))

    def put(self, rows: NDArray[np.intp], part: RowsResult) -> None:
        """Store the results of some of the rows."""
        for whole, values in zip(vars(self).values(), vars(part).values(), strict=True):
            whole[rows] = values


def read_rows(
    scene: Scene,
    moments: ArrayLike | None,
    forces: ArrayLike | None,
    tensions: ArrayLike | None = None,
    lengths: ArrayLike | None = None,
) -> BatchLoads:
    """The rows of a batch from what the caller gives (batch.py).

    Raises `InputError` for no rows, a wrong shape, numbers that are not finite, or loads the scene has not.
    """
    given = dict(zip(LOADS, (moments, forces, tensions, lengths), strict=True))
    pulled, controlled = scene.pulled_tendons, scene.controlled_tendons
    of_scene = dict(zip(LOADS, (scene.moments, scene.forces, pulled, controlled), strict=True))
    tables = {name: _values(name, v, of_scene[name]) for name, v in given.items() if v is not None}
    if not tables:
        refuse_batch("The batch has no rows.", ", ".join(given), "none was given", "nothing to solve for")
    counts = {name: len(table) for name, table in tables.items()}
    if len(set(counts.values())) > 1:
        text = ", ".join(f"{count} rows of {name}" for name, count in counts.items())
        refuse_batch("The rows of the loads do not match.", ", ".join(counts), text, "each row is one sample")
    rows = next(iter(counts.values()))
    filled = {}
    for name, loads in (("moments", scene.moments), ("forces", scene.forces)):
        values = np.tile(np.array([load.value for load in loads]).reshape(1, -1, 3), (rows, 1, 1))
        if name in tables:
            table = tables[name]
            axes = [scene.load_axes(load) for load in loads[: table.shape[1]]]
            values[:, : table.shape[1]] = np.einsum("lij,blj->bli", axes, table)
        filled[name] = values
    own = {"tensions": [t.tension for t in pulled], "lengths": [t.length for t in controlled]}
    for name, values in own.items():
        filled[name] = np.tile(np.array(values, float), (rows, 1))
        if name in tables:
            filled[name][:, : tables[name].shape[1]] = tables[name][..., 0]
    most_bent, most_pushed = (
        values[np.argmax(np.linalg.norm(values, axis=-1), axis=0), np.arange(values.shape[1])]
        for values in (filled["moments"], filled["forces"])
    )
    most_pulled, shortest = filled["tensions"].max(axis=0), filled["lengths"].min(axis=0)
    return BatchLoads(_with_values(scene, most_bent, most_pushed, most_pulled, shortest), **filled)


def _values(name: str, given: ArrayLike, loads: Sequence[Moment | Force | Tendon]) -> Floats:
    """Values (B, k, 3) of the first k loads, as given, checked; of tensions and lengths (B, k, 1)."""
    kind, components = ("tendon", 1) if name in ("tensions", "lengths") else (name[:-1], 3)
    if not loads:
        which = f" with a {name[:-1]}" if components == 1 else ""
        refuse_batch(
            f"The scene has no {kind}{which} for the rows of a batch.", name,
            f"no [[{kind}]]{which} in the scene",
            f"a batch varies the [[{kind}]] tables of its scene", f"add a [[{kind}]] with any value",
        )  # fmt: skip
    try:
        values = np.asarray(given, dtype=float)
    except (TypeError, ValueError) as error:
        refuse_batch(
            f"The {name} of the batch are no numbers.", name, str(error), "rows of unequal length, or text"
        )
    shape = " or ".join(dict.fromkeys(("(B, 3)", f"(B, {len(loads)}, 3)")))
    if components == 1:
        shape = " or ".join(dict.fromkeys(("(B,)", f"(B, {len(loads)})")))
        values = values[..., None]
    values = values[:, None] if values.ndim == 2 else values
    if values.ndim != 3 or values.shape[-1] != components or values.shape[1] not in (1, len(loads)):
        refuse_batch(
            f"The {name} of the batch have the wrong shape.", name,
            f"shape {np.shape(given)}, must be {shape}",
            f"one row a sample; {shape.split(' or ')[0]} are rows for the first {kind}",
            "add the axis of rows: values[None]",
        )  # fmt: skip
    if len(values) == 0:
        refuse_batch("The batch has no rows.", name, f"shape {np.shape(given)}", "an empty table of loads")
    bad = np.flatnonzero(~np.isfinite(values).all(axis=(1, 2)))
    if len(bad):
        refuse_batch(
            f"The {name} of the batch are not finite.", f"{name}[{bad[0]}]",
            f"{values[bad[0]].tolist()} in {len(bad)} of {len(values)} rows",
            "a division by zero or missing data where the rows were made", "remove these rows",
        )  # fmt: skip
    if name == "lengths" and values.min() <= 0.0:
        row = int(np.argmin(values.min(axis=(1, 2))))
        refuse_batch(
            "A tendon has a length.", f"{name}[{row}]", f"length {values[row].min():g} m, must be > 0",
            "a sign, or changes of length in the place of lengths", "give the lengths themselves",
        )  # fmt: skip
    if name == "tensions" and values.min() < 0.0:
        row = int(np.argmin(values.min(axis=(1, 2))))
        refuse_batch(
            "A tendon cannot push.", f"{name}[{row}]", f"tension {values[row].min():g} N, must be >= 0",
            "a sign, or a sweep that begins below zero", "take the tendon on the other side instead",
        )  # fmt: skip
    return values


def _with_values(scene: Scene, moments: Floats, forces: Floats, tensions: Floats, lengths: Floats) -> Scene:
    pulls, wanted = iter(tensions.tolist()), iter(lengths.tolist())
    return replace(
        scene,
        moments=tuple(replace(m, value=value) for m, value in zip(scene.moments, moments, strict=True)),
        forces=tuple(replace(f, value=value) for f, value in zip(scene.forces, forces, strict=True)),
        tendons=tuple(
            replace(t, length=next(wanted)) if t.tension is None else replace(t, tension=next(pulls))
            for t in scene.tendons
        ),
    )


def refuse_batch(
    what: str, where: str, value: str, cause: str, advice: str = "give one row for each sample"
) -> NoReturn:
    """Refuse what the caller of `solve_batch` gave."""
    refuse(what, f"solve_batch, {where}", value, cause, advice)
