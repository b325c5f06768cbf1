"""The plan of a data set: everything that decides its bytes, by which finished parts are known again."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import ancf
from surrogate.blocks import ROWS, Block
from surrogate.design import Design
from surrogate.gate import Gate, solver_digest
from surrogate.sampling import Sample, sample
from validation.certificate import digests

SCHEMA = 1
PACKAGES = ("numpy", "scipy", "numba")
WORDS = {
    "schema": "the schema of data sets",
    "design": "the design",
    "rows_per_block": "rows per block",
    "solver": "the code of the solver (digest of ancf/)",
    "certificate": "the certificate",
    "versions": "versions of packages",
}


@dataclass(frozen=True, eq=False)
class Plan:
    """A design, what the gate answered, and the code and packages that solve it."""

    design: Design
    gate: Gate

    @cached_property
    def record(self) -> dict[str, Any]:
        """What decides the bytes, as plain data in the order in which a shard gives it back."""
        record = {
            "schema": SCHEMA,
            "design": dict(self.design.tables),
            "rows_per_block": ROWS,
            "solver": solver_digest(),
            "certificate": self.gate.id,
            "versions": versions(),
        }
        return json.loads(json.dumps(record, sort_keys=True))

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the record."""
        return digests.of_json(self.record)

    @cached_property
    def sample(self) -> Sample:
        """All rows."""
        return sample(self.design)

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return -(-self.design.count // ROWS)

    def rows(self, number: int) -> slice:
        """Rows of a block."""
        return slice(number * ROWS, min((number + 1) * ROWS, self.design.count))

    def block(self, number: int) -> Block:
        """A block as a worker gets it."""
        rows = self.rows(number)
        loads = self.design.values(self.sample.points[rows])
        return Block(number, rows.start, self.design.scene, loads, self.gate)


def versions() -> dict[str, str]:
    """Versions of Python (without its patch level) and of the packages that compute."""
    found = {"ancf": ancf.__version__, "python": ".".join(platform.python_version_tuple()[:2])}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def differences(theirs: Mapping[str, Any], ours: Mapping[str, Any]) -> list[str]:
    """In what the record of a plan differs from another, one sentence each; empty when they are equal."""
    found = []
    for key in sorted({*theirs, *ours}):
        there, here = theirs.get(key), ours.get(key)
        if there == here:
            continue
        if isinstance(there, Mapping) and isinstance(here, Mapping):
            parts = [name for name in sorted({*there, *here}) if there.get(name) != here.get(name)]
            there = ", ".join(f"{name} = {there.get(name)}" for name in parts)
            here = ", ".join(f"{name} = {here.get(name)}" for name in parts)
        found.append(f"{WORDS.get(key, key)} differs: {_short(there)} there, {_short(here)} here")
    return found


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 160 else f"{text[:160]}..."
