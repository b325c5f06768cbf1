"""What a model learns: an arm, the box of its moments, and solved rows for training, validation and test."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.errors import InputError, Message
from ancf.scene_file import scene_from_dict
from surrogate.arm import Arm
from surrogate.dataset import DataSet
from surrogate.sampling import sobol_points, split_sizes

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Samples:
    """Poses (n, 3, 4) [m, -] in SCS and the moments (n, 3) [N m], in their frame, that cause them."""

    poses: Floats
    moments: Floats

    def __len__(self) -> int:
        return len(self.poses)

    def taken(self, rows: NDArray[Any]) -> Samples:
        """Some of the rows, by number or by mask."""
        return Samples(self.poses[rows], self.moments[rows])


@dataclass(frozen=True, eq=False)
class Problem:
    """An inverse problem and its data."""

    arm: Arm
    bounds: Floats  # (3, 2) N m
    train: Samples
    validation: Samples
    test: Samples
    tables: Mapping[str, Any]  # the scene in the format of a scene file
    certificate: str  # id, or UNVALIDATED
    name: str

    @property
    def all(self) -> Samples:
        """Every row."""
        parts = (self.train, self.validation, self.test)
        return Samples(np.concatenate([p.poses for p in parts]), np.concatenate([p.moments for p in parts]))

    @property
    def deviation(self) -> Floats:
        """Deviation (3,) [N m] of the training moments, the unit of z-scores; E I/L if one never varies."""
        found = self.train.moments.std(axis=0)
        return np.where(found > 0.0, found, self.arm.unit)

    def without(self, slab: Any, seed: int = 0) -> tuple[Problem, Samples]:
        """The problem without the rows whose moments `slab` (n, 3) -> (n,) picks, and those rows."""
        rows = self.all
        inside = np.asarray(slab(rows.moments))
        kept = rows.taken(~inside)
        parts = random_split(len(kept), seed)
        split = dict(zip(("train", "validation", "test"), (kept.taken(p) for p in parts), strict=True))
        return replace(self, **split), rows.taken(inside)


def problem_of(data: DataSet) -> Problem:
    """The inverse problem of a data set.

    Raises
    ------
    InputError : the scene is not a straight arm under a tip moment, or a part of the split is empty.
    """
    tables = {key: value for key, value in data.card["plan"]["design"].items() if key != "design"}
    arm = Arm.of(scene_from_dict(tables))
    other = [v.name for v in data.design.variables if (v.load, v.index) != ("moment", 0)]
    if other:
        raise InputError(
            Message(
                "Loads other than the tip moment vary in these data.",
                "loads of the data set",
                ", ".join(other),
                "the inverse sought here is from the tip pose to the first moment, all else being fixed",
                "take a design in which only the first moment varies",
            )
        )
    parts = {name: _samples(data, name) for name in ("train", "validation", "test")}
    short = [name for name, part in parts.items() if len(part) < 2]
    if short:
        raise InputError(
            Message(
                f"The data have too few rows for {' and '.join(short)}.",
                "split of the data set",
                ", ".join(f"{name} {len(part)}" for name, part in parts.items()),
                "a very small design, or rows without equilibrium",
                "make a larger data set",
            )
        )
    bounds = np.array(data.card["moment_range"], dtype=float)
    return Problem(
        arm, bounds, **parts, tables=tables, certificate=data.card["certificate"], name=data.card["preset"]
    )


def solved_problem(arm: Arm, moments: Floats, tables: Mapping[str, Any], name: str, seed: int = 0) -> Problem:
    """A problem of moments (n, 3) [N m] that are solved here, outside the gate: stamped UNVALIDATED."""
    from surrogate.gate import UNVALIDATED

    rows = solved(arm, moments)
    train, validation, test = (rows.taken(part) for part in random_split(len(rows), seed))
    bounds = np.stack([moments.min(axis=0), moments.max(axis=0)], axis=1)
    return Problem(arm, bounds, train, validation, test, tables, UNVALIDATED, name)


def solved(arm: Arm, moments: Floats) -> Samples:
    """Converged rows of moments (n, 3) [N m]."""
    found = arm.solve(moments)
    good = found.status == "converged"
    return Samples(found.poses[good], np.asarray(moments)[good])


def box_design(bounds: Floats, count: int, seed: int, scale: float = 1.0) -> Floats:
    """Moments (count, 3) [N m] spread over the box by a scrambled Sobol sequence; `scale` widens the box."""
    points = sobol_points(np.random.default_rng([seed, 77]), count, 3)
    middle, half = bounds.mean(axis=1), 0.5 * scale * (bounds[:, 1] - bounds[:, 0])
    return middle + (2.0 * points - 1.0) * half


def random_split(count: int, seed: int) -> tuple[NDArray[np.intp], ...]:
    """Row numbers for training, validation and test, 70/15/15."""
    order = np.random.default_rng([seed, 5]).permutation(count)
    _, validation, test = split_sizes(count)
    return order[validation + test :], order[:validation], order[validation : validation + test]


def _samples(data: DataSet, split: str) -> Samples:
    rows = data.rows(split)
    return Samples(data.pose[rows], data.moments[rows])


def plain_tables(tables: Mapping[str, Any]) -> dict[str, Any]:
    """The tables as JSON can hold them."""
    return json.loads(json.dumps(dict(tables)))
