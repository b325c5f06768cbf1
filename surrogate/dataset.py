"""Data sets of tip poses and the loads that cause them: the record and how it is read from a folder.

A folder holds ``data.npz`` and ``card.json``. `load` believes neither: arrays are held against the digests
of the card, the stamp of one against that of the other.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from ancf.errors import InputError, Message
from surrogate import npz
from surrogate.design import Design, design_from_dict
from surrogate.gate import UNVALIDATED
from surrogate.plan import SCHEMA
from surrogate.sampling import SPLIT_NAMES
from validation.certificate import digests

Floats = NDArray[np.float64]

DATA, CARD = "data.npz", "card.json"
# What readers need of a card, and of what kind.
KINDS = {
    "arrays": dict, "certificate": str, "plan": dict, "reasons": list, "preset": str, "loads": list,
    "moment_range": list, "rows": int, "rows_by_status": dict,
}  # fmt: skip
STAMP = "certificate"  # name of the array that carries the stamp


class DataError(InputError):
    """A data set cannot be used: missing, damaged, of another schema, or edited (exit code 2)."""


@dataclass(frozen=True, eq=False)
class DataSet:
    """Rows of a design and their equilibria; a row without one keeps its status and its last pose."""

    moments: Floats  # (n, 3) N m of the scene's first moment, in the frame that the card names; else 0
    loads: Floats  # (n, k) values of the variables, named and with units in card["loads"]
    pose: Floats  # (n, 3, 4) columns r [m], r_x, r_y, r_z [-] at the tip, in SCS
    stretch: Floats  # (n, 3) lengths of r_x, r_y, r_z
    status: NDArray[np.str_]  # (n,)
    iterations: NDArray[np.int64]  # (n,) linear solves
    residual: Floats  # (n,) dimensionless
    load_factor: Floats  # (n,) 1 where converged
    split: NDArray[np.str_]  # (n,) "train" | "validation" | "test"
    group: NDArray[np.int64]  # (n,) level of the first variable of a grid, sequence of a Sobol design
    card: dict[str, Any]

    def __len__(self) -> int:
        return len(self.pose)

    @cached_property
    def design(self) -> Design:
        """The design, with the scene under which moments can be solved again."""
        return design_from_dict(self.card["plan"]["design"], "card.json")

    @property
    def validated(self) -> bool:
        """Whether a certificate vouches for these data."""
        return self.card["certificate"] != UNVALIDATED

    def rows(self, split: str) -> NDArray[np.intp]:
        """Converged rows of a split: what a model may be trained on or tested with."""
        return np.flatnonzero((self.split == split) & (self.status == "converged"))


ARRAYS = tuple(field.name for field in fields(DataSet) if field.name != "card")


def load(path: str | PathLike[str]) -> DataSet:
    """Read a data set from its folder (or its data.npz).

    Raises
    ------
    DataError : files missing or damaged, another schema, arrays that are not those of the card.
    """
    folder = Path(path)
    folder = folder.parent if folder.name == DATA else folder
    card = read_card(folder)
    try:
        arrays = npz.read(folder / DATA)
    except OSError as error:
        refuse(folder / DATA, "The data cannot be read.", error.strerror or str(error))
    except npz.DamagedFile as error:
        refuse(folder / DATA, "The data are damaged.", str(error))
    described = card["arrays"]
    wrong = [f"array {name!r} is missing" for name in (*ARRAYS, STAMP) if name not in arrays]
    wrong += [
        f"array {name!r} is not the one of the card"
        for name in ARRAYS
        if name in arrays and described.get(name) != npz.described(arrays[name])
    ]
    if not wrong and str(arrays[STAMP]) != card["certificate"]:
        wrong = [f"the data are stamped {arrays[STAMP]}, the card {card['certificate']}"]
    if not wrong and card["certificate"] not in (UNVALIDATED, card["plan"].get("certificate")):
        wrong = [f"the card is stamped {card['certificate']}, its plan {card['plan'].get('certificate')}"]
    if wrong:
        refuse(folder / DATA, "Data and card do not belong together.", "; ".join(wrong))
    found = DataSet(**{name: arrays[name] for name in ARRAYS}, card=card)
    _check(folder / DATA, found)
    return found


def read_card(folder: Path) -> dict[str, Any]:
    """The card of a folder; raises `DataError`."""
    path = folder / CARD
    try:
        card = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        refuse(path, "The data card cannot be read.", error.strerror or str(error))
    except ValueError as error:
        refuse(path, "The data card is damaged.", f"it is not JSON: {error}")
    if not isinstance(card, dict) or card.get("schema") != SCHEMA:
        schema = card.get("schema") if isinstance(card, dict) else None
        refuse(path, "The data are of another schema.", f"schema {schema}, this version knows {SCHEMA}")
    wrong = [key for key, kind in KINDS.items() if not isinstance(card.get(key), kind)]
    if wrong:
        refuse(path, "The data card is not complete.", f"{', '.join(wrong)} missing or of another kind")
    if digests.of_json(card["plan"]) != card.get("plan_id"):
        refuse(path, "The data card was changed.", "plan_id is not the digest of plan")
    return card


def _check(path: Path, found: DataSet) -> None:
    """Shapes and numbers of data that agree with their card."""
    n = len(found.pose)
    wrong = []
    if found.pose.shape != (n, 3, 4):
        wrong.append(f"pose has the shape {found.pose.shape}, must be (n, 3, 4)")
    wrong += [
        f"{name} has {len(getattr(found, name))} rows, pose {n}"
        for name in ARRAYS
        if len(getattr(found, name)) != n
    ]
    for name in ("moments", "loads", "pose", "stretch"):
        if not np.isfinite(getattr(found, name)).all():
            wrong.append(f"{name} is not finite")
    if not _is_box(found.card["moment_range"]):
        wrong.append("moment_range of the card is not three pairs of numbers")
    if not set(np.unique(found.split)) <= set(SPLIT_NAMES):
        wrong.append(f"split holds words other than {', '.join(SPLIT_NAMES)}")
    if wrong:
        refuse(path, "The data cannot be used.", "; ".join(wrong))


def _is_box(value: Any) -> bool:
    try:
        return np.shape(np.asarray(value, dtype=float)) == (3, 2)
    except (TypeError, ValueError):
        return False


def refuse(path: Path, what: str, value: str) -> NoReturn:
    """Raise `DataError` about a file of a data set."""
    raise DataError(
        Message(
            what,
            str(path),
            value,
            "an interrupted copy, an edit by hand, or another version of the program",
            "copy it again, or remove it and make it again with `ancf dataset`",
        )
    )
