"""The journal of a full run: each finished task as one line, so that an interruption loses the one in hand.

A journal serves only the code, cases and library versions that wrote it; any other is discarded by name.
Lines carry a checksum, for a kill may cut one short.
"""

from __future__ import annotations

import json
import os
import types
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from enum import Enum
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union, get_args, get_origin, get_type_hints

from validation.digests import differences, of_json, sha256
from validation.outcome import Outcome, Row
from validation.record import write_text

if TYPE_CHECKING:
    from ancf.solution import Solution

FILE = "journal.jsonl"


@dataclass(frozen=True)
class StoredOutcome:
    """An outcome read back: as `Outcome`, but its solution is computed again when it is drawn."""

    observed: Mapping[str, float]
    rows: list[Row]
    scene: Mapping[str, Any] | None
    reference_error: Mapping[str, float]
    notes: list[str]
    solved: bool = field(default=False)

    @cached_property
    def solution(self) -> Solution | None:
        """The last solution; None where there was none."""
        if not self.solved or self.scene is None:
            return None
        from validation.scenes import solve

        return solve(self.scene)


class Journal:
    """Finished tasks of a run in a folder.

    Parameters
    ----------
    folder : output folder of the run; the file is `FILE` in it
    key : what the results depend on, by name (digests, versions, scope)
    fresh : discard what is there
    """

    def __init__(self, folder: Path, key: Mapping[str, str], fresh: bool = False) -> None:
        self.path = folder / FILE
        self.notices: list[str] = []
        self.found: dict[tuple[str, str], dict[str, Any]] = {}
        lines = [] if fresh or not self.path.exists() else self._read(key)
        # Whole and good lines only, so that what is appended starts on a line of its own.
        header = json.dumps({"key": dict(key)})
        write_text(self.path, "\n".join([header, *lines]) + "\n")

    def _read(self, key: Mapping[str, str]) -> list[str]:
        """Good lines of the file; fills `found`."""
        header, *lines = self.path.read_text(encoding="utf-8", errors="replace").split("\n")
        try:
            other = differences(json.loads(header)["key"], key)
        except (ValueError, KeyError, TypeError, AttributeError):
            other = ["its first line is damaged"]
        if other:
            more = f" and {len(other) - 3} more" if len(other) > 3 else ""
            self.notices.append(f"{self.path} is discarded: {'; '.join(other[:3])}{more}")
            return []
        good, bad = [], 0
        for line in lines:
            if not line:
                continue
            checksum, _, text = line.partition(" ")
            if checksum != sha256(text.encode()):
                bad += 1
                continue
            entry = json.loads(text)
            self.found[entry["part"], entry["name"]] = entry
            good.append(line)
        if bad:
            self.notices.append(f"{self.path}: {bad} damaged line{'s' * (bad > 1)} left out and run again")
        if good:
            self.notices.append(f"{self.path}: {len(good)} finished results are taken from it")
        return good

    def add(self, part: str, name: str, results: list[Any], **more: Any) -> None:
        """Append the results of a task; on the disk when this returns."""
        entry = {"part": part, "name": name, "results": [keep(result) for result in results], **more}
        text = json.dumps(entry)  # infinite numbers are kept as they are: only `revive` reads this file
        with self.path.open("a", encoding="utf-8") as file:
            file.write(f"{sha256(text.encode())} {text}\n")
            file.flush()
            os.fsync(file.fileno())

    def remove(self) -> None:
        """Delete the file: the run is finished, and the next one starts anew."""
        self.path.unlink(missing_ok=True)


def run_key(subject: Mapping[str, str], configuration: Mapping[str, str], **more: Any) -> dict[str, str]:
    """What the results of a run depend on, by name."""
    return {**subject, **configuration, **{name: of_json(value)[:16] for name, value in more.items()}}


def keep(value: Any) -> Any:
    """A record as plain data; what a task declares (cases, studies) is left to the code."""
    if isinstance(value, Outcome | StoredOutcome):
        solved = value.solved if isinstance(value, StoredOutcome) else value.solution is not None
        kept = ("observed", "rows", "scene", "reference_error", "notes")
        return {**{name: keep(getattr(value, name)) for name in kept}, "solved": solved}
    if is_dataclass(value):
        return {f.name: keep(getattr(value, f.name)) for f in fields(value) if not _declared(value, f.name)}
    if isinstance(value, Mapping):
        return {str(key): keep(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [keep(item) for item in value]
    if isinstance(value, Enum):
        return value.value
    tolist = getattr(value, "tolist", None)  # arrays and numpy scalars
    return tolist() if tolist is not None else value


def revive(kind: Any, data: Any, declared: Mapping[type, Any]) -> Any:
    """The inverse of `keep` for a type as an annotation states it.

    Parameters
    ----------
    kind : annotation: a dataclass, list, tuple, mapping, optional, enumeration or plain type
    data : what `keep` gave
    declared : objects of the present code for fields of these types
    """
    if kind is Outcome:
        rows = [Row(**row) for row in data["rows"]]
        return StoredOutcome(**{**data, "rows": rows})
    if isinstance(kind, type) and is_dataclass(kind):
        hints = get_type_hints(kind)
        return kind(
            **{
                f.name: declared[hints[f.name]]
                if hints[f.name] in declared
                else revive(hints[f.name], data[f.name], declared)
                for f in fields(kind)
            }
        )
    origin, arguments = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        some = [argument for argument in arguments if argument is not type(None)]
        return None if data is None else revive(some[0], data, declared)
    if origin is list:
        return [revive(arguments[0], item, declared) for item in data]
    if origin is tuple:
        return tuple(data)
    if origin is dict:
        return {name: revive(arguments[1], item, declared) for name, item in data.items()}
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind(data)
    return data


def _declared(record: Any, name: str) -> bool:
    """Whether a field refers to the case or study that the code declares; it is not a result."""
    return name in ("case", "study") and is_dataclass(getattr(record, name))
