"""Finished blocks on disk: written whole or not at all, and taken back only if they are of the same plan."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from ancf.errors import InputError, Message
from surrogate import npz
from surrogate.blocks import RESULTS, Solved
from surrogate.plan import SCHEMA, Plan, differences
from surrogate.whole_file import write_bytes, writing

FOLDER, PLAN = "blocks", "plan.json"


class OtherPlan(InputError):
    """A folder holds the parts of another data set (exit code 2)."""


@dataclass(frozen=True, eq=False)
class Store:
    """The blocks of one plan in the folder of its data set."""

    folder: Path
    plan: Plan

    @property
    def blocks(self) -> Path:
        """Where the blocks lie."""
        return self.folder / FOLDER

    @property
    def begun(self) -> bool:
        """Whether there are blocks, of whatever plan."""
        return (self.blocks / PLAN).exists()

    def open(self) -> bool:
        """Make the folder, or make sure that it is of this plan; whether it is new.

        Raises `OtherPlan`, and `InputError` where it cannot be written.
        """
        path = self.blocks / PLAN
        if self.begun:
            compare(path, read_plan(self.folder), self.plan)
            return False
        with writing(self.folder):
            self.blocks.mkdir(parents=True, exist_ok=True)
            write_bytes(path, json.dumps(self.plan.record, indent=1).encode())
        return True

    def path(self, number: int) -> Path:
        """File of a block."""
        return self.blocks / f"{number:06d}.npz"

    def write(self, solved: Solved) -> None:
        """Keep a solved block; raises `InputError` when the disk is full."""
        arrays = {
            **solved.arrays,
            "plan": np.array(self.plan.digest),
            "outside": np.array(solved.outside, dtype=str),
        }
        with writing(self.folder):
            npz.write(self.path(solved.number), arrays)

    def read(self, number: int) -> Solved:
        """Take a block back; raises `npz.DamagedFile` when it is not whole, not of this plan or not there."""
        path = self.path(number)
        try:
            arrays = npz.read(path)
        except FileNotFoundError:
            raise npz.DamagedFile(f"{path.name} is missing") from None
        missing = [name for name in (*RESULTS, "plan", "outside") if name not in arrays]
        if missing:
            raise npz.DamagedFile(f"{path.name} lacks {', '.join(missing)}")
        if str(arrays["plan"]) != self.plan.digest:
            raise npz.DamagedFile(f"{path.name} is of another plan")
        rows = self.plan.rows(number)
        counts = {len(arrays[name]) for name in RESULTS}
        if counts != {rows.stop - rows.start}:
            raise npz.DamagedFile(f"{path.name} has {counts} rows instead of {rows.stop - rows.start}")
        results = {name: arrays[name] for name in RESULTS}
        return Solved(
            number, results, [str(reason) for reason in arrays["outside"]], self.plan.record["solver"]
        )

    def unfinished(self, numbers: Iterable[int]) -> tuple[list[int], list[str]]:
        """Which of some blocks are still to be solved, and what was found wrong with files that are there."""
        wanted, damaged = [], []
        for number in numbers:
            try:
                self.read(number)
            except npz.DamagedFile as error:
                wanted.append(number)
                if self.path(number).exists():
                    damaged.append(str(error))
        return wanted, damaged

    def take_in(self, other: Path) -> int:
        """Copy the blocks of a shard in another folder and count them; raises `InputError` for a bad one."""
        compare(other / FOLDER / PLAN, read_plan(other), self.plan)
        source = Store(other, self.plan)
        taken = 0
        for number in self.unfinished(range(self.plan.blocks))[0]:
            if not source.path(number).exists():
                continue
            try:
                source.read(number)
            except npz.DamagedFile as error:
                refuse_shard(source.path(number), str(error))
            with writing(self.folder):
                write_bytes(self.path(number), source.path(number).read_bytes())
            taken += 1
        return taken

    def clear(self) -> None:
        """Remove the blocks: the data set is whole, or may not be made."""
        shutil.rmtree(self.blocks, ignore_errors=True)


def read_plan(folder: Path) -> dict[str, Any]:
    """The record of the plan whose blocks lie in a folder; raises `InputError`."""
    path = folder / FOLDER / PLAN
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        refuse_shard(path, error.strerror or str(error))
    except ValueError as error:
        refuse_shard(path, f"it is not JSON: {error}")
    schema = record.get("schema") if isinstance(record, dict) else None
    if schema != SCHEMA:
        refuse_shard(path, f"schema {schema}, this version knows {SCHEMA}")
    return record


def compare(path: Path, theirs: Mapping[str, Any], plan: Plan) -> None:
    """Raise `OtherPlan` with everything in which a stored record differs from a plan."""
    different = differences(theirs, plan.record)
    if different:
        raise OtherPlan(
            Message(
                "The folder holds another data set, or parts of one.",
                str(path),
                "; ".join(different),
                "the design, the code or the certificate changed since it was begun",
                "name another folder, or remove that one if nobody needs it",
            )
        )


def refuse_shard(path: Path, value: str) -> NoReturn:
    """Raise `InputError` about a part that cannot be merged."""
    raise InputError(
        Message(
            "A part of the data set cannot be used.",
            str(path),
            value,
            "a copy that was cut short, a shard that was not finished, or another version of the program",
            "copy it again, or run that shard again: it goes on where it stopped",
        )
    )
