"""One table of a scene file: typed reading of its keys, with messages that say where and why.

Everything here knows TOML values and key paths, and nothing about rods.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from ancf.errors import Message, SceneError
from ancf.units import NUMBER, Dimension, to_si

REQUIRED: Any = object()  # default of a key that must be given
_SHOWN = 60  # characters of a bad value that a message repeats


@dataclass(frozen=True)
class Limit:
    """A condition on a number, and the words in which a message states it."""

    holds: Callable[[float], bool]
    words: str


FINITE = Limit(lambda v: True, "finite")
# Wide enough for any rod; narrow enough that E I / L^2 and the like neither overflow nor vanish in float64.
SIZE = Limit(lambda v: 1e-20 <= v <= 1e20, "> 0, and between 1e-20 and 1e20")
MODULUS = Limit(lambda v: 1e-30 <= v <= 1e30, "> 0, and between 1e-30 and 1e30")
SIGNED = Limit(lambda v: abs(v) <= 1e20, "between -1e20 and 1e20")
FRACTION = Limit(lambda v: 0.0 <= v <= 1.0, "between 0 and 1")


def show(value: object) -> str:
    """Return a short printable form of any value."""
    try:
        text = repr(value)
    except ValueError:  # Python refuses to print whole numbers of more than 4300 digits
        return "a whole number of thousands of digits"
    return text if len(text) <= _SHOWN else text[:_SHOWN] + "..."


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Return the known word most like `word`, or None when none is close."""
    found = difflib.get_close_matches(word.lower(), list(known), n=1, cutoff=0.5)
    return found[0] if found else None


class Table:
    """A table of the scene file, its place in it, and the reading of its values.

    Parameters
    ----------
    data : object
        The table as TOML has it; anything that is no mapping is refused.
    source : str
        File name, or "scene" for a dictionary.
    path : str
        Key path such as ``rod[0].section``; empty for the whole file.
    """

    def __init__(self, data: object, source: str, path: str = "") -> None:
        self.source, self.path = source, path
        if not isinstance(data, Mapping):
            self.refuse(
                "",
                f"{path or 'The scene'} must be a table.",
                f"{show(data)} is {_kind(data)}",
                "a table in braces or under its own heading is expected here",
                "write { key = value, ... }; see the scene file in the README",
            )
        self.data: Mapping[Any, Any] = data

    def where(self, key: str = "") -> str:
        """Return file and key path of a key of this table."""
        path = f"{self.path}.{key}" if self.path and key else self.path or key
        return f"{self.source}: {path}" if path else self.source

    def refuse(self, key: str, what: str, value: str, cause: str, advice: str) -> NoReturn:
        """Raise a `SceneError` at a key of this table."""
        raise SceneError(Message(what, self.where(key), value, cause, advice))

    def refuse_later(self, key: str, what: str, now: str) -> NoReturn:
        """Refuse something that the scene format knows and this version does not."""
        self.refuse(
            key,
            f"{what} is not in this version.",
            f"this version knows {now}",
            "the scene format reserves it for a later version; it is refused, never ignored",
            f"use {now}, or remove it",
        )

    def expect_keys(self, known: Sequence[str], later: Sequence[str] = ()) -> None:
        """Refuse keys that are unknown (naming the nearest valid one) or not in this version."""
        for key in (key if isinstance(key, str) else show(key) for key in self.data):
            if key in known:
                continue
            if key in later:
                self.refuse_later(key, f'"{key}"', "the keys " + ", ".join(known))
            close = nearest(key, [*known, *later])
            self.refuse(
                key,
                f"Unknown key {show(key)}.",
                f"{show(key)} is none of {', '.join(known)}",
                "a misspelt key" if close else "the key does not belong into this table",
                f'did you mean "{close}"?' if close else "remove it, or look for its table in the README",
            )

    def get(self, key: str, default: Any) -> Any:
        """Return the raw value of a key; a missing key without default is refused."""
        if key in self.data:
            return self.data[key]
        if default is REQUIRED:
            self.refuse(
                key,
                f'The key "{key}" is missing.',
                f"only {', '.join(map(str, self.data)) or 'an empty table'} given",
                f'"{key}" has no default',
                f"add {key} = ...",
            )
        return default

    def number(
        self, key: str, dimension: Dimension = NUMBER, default: Any = REQUIRED, limit: Limit = FINITE
    ) -> float:
        """Read a finite number, or a text with a unit, within a limit [dimension.unit]."""
        return self.to_number(self.get(key, default), key, dimension, limit)

    def to_number(self, value: object, key: str, dimension: Dimension, limit: Limit = FINITE) -> float:
        """Check one value that stands at `key` and return it as an SI number."""
        if isinstance(value, str):
            number = to_si(value, dimension, self.where(key))
        elif isinstance(value, Real) and not isinstance(value, bool):
            try:
                number = float(value)
            except OverflowError:
                number = math.inf
        else:
            self._refuse_type(key, value, f"a number ({dimension.name}, {dimension.unit})", dimension.example)
        if not math.isfinite(number):
            self.refuse(
                key,
                f"{key} is not finite.",
                f"{show(value)}; a finite {dimension.name} is needed",
                "inf, nan or a number beyond 1.8e308",
                f"give a finite number [{dimension.unit}]",
            )
        if not limit.holds(number):
            self.refuse(
                key,
                f"{key} is out of range.",
                f"{show(value)}; {key} must be {limit.words} [{dimension.unit}]",
                "a slip of sign, of unit or of magnitude",
                f"give a {dimension.name} that is {limit.words} (numbers are SI: {dimension.unit})",
            )
        return number

    def vector(
        self,
        key: str,
        length: int,
        dimension: Dimension,
        default: Any = REQUIRED,
        limit: Limit = FINITE,
    ) -> NDArray[np.float64]:
        """Read a list of `length` numbers (length,) [dimension.unit]; texts with units may be mixed in."""
        value = self.items(key, default, f"a list of {length} numbers [{dimension.unit}]")
        if len(value) != length:
            self.refuse(
                key,
                f"{key} has {len(value)} entries.",
                f"{show(value)}; exactly {length} are needed",
                "a component is missing or one too many was given",
                f"give {length} numbers in brackets [{dimension.unit}]",
            )
        return np.array([self.to_number(v, f"{key}[{i}]", dimension, limit) for i, v in enumerate(value)])

    def items(self, key: str, default: Any, expected: str) -> list[Any]:
        """Read a list, of anything."""
        value = self.get(key, default)
        if isinstance(value, np.ndarray):
            value = value.tolist()
        if not isinstance(value, list | tuple):
            self._refuse_type(key, value, expected, "[..., ...]")
        return list(value)

    def whole(self, key: str, lowest: int, highest: int, default: Any = REQUIRED) -> int:
        """Read a whole number between two limits, both included."""
        value = self.get(key, default)
        if not isinstance(value, Integral) or isinstance(value, bool):
            self._refuse_type(key, value, f"a whole number >= {lowest}, without a decimal point", str(lowest))
        number = int(value)
        if not lowest <= number <= highest:
            self.refuse(
                key,
                f"{key} is out of range.",
                f"{show(value)}; a whole number from {lowest} to {highest} is needed",
                "too small to mean anything" if number < lowest else "a slip of the keyboard is likely",
                f"give a whole number from {lowest} to {highest}",
            )
        return number

    def known(self, key: str, names: Sequence[str], thing: str, elsewhere: str) -> str:
        """Read the name of a `thing` of the scene, by default the first; `elsewhere`: why others may not."""
        name = self.text(key, names[0])
        if name not in names:
            close = nearest(name, names)
            self.refuse(
                key,
                f"There is no {thing} named {show(name)}.",
                f"{show(name)} is none of {', '.join(names)}",
                "a misspelt name" if close else elsewhere,
                f'did you mean "{close}"?' if close else f'write {key} = "{names[0]}"',
            )
        return name

    def word(
        self, key: str, choices: Sequence[str], default: Any = REQUIRED, later: Sequence[str] = ()
    ) -> str:
        """Read one of a few words; those in `later` are not in this version."""
        value = self.get(key, default)
        if not isinstance(value, str):
            self._refuse_type(key, value, f"one of {', '.join(choices)}, in quotes", f'"{choices[0]}"')
        if value in later:
            self.refuse_later(key, f'{key} = "{value}"', " | ".join(choices))
        if value not in choices:
            close = nearest(value, [*choices, *later])
            self.refuse(
                key,
                f"Unknown {key} {show(value)}.",
                f"{show(value)} is none of {', '.join(choices)}",
                "a misspelt word" if close else f"{key} knows only these words",
                f'did you mean "{close}"?' if close else f'write {key} = "{choices[0]}"',
            )
        return value

    def text(self, key: str, default: Any = REQUIRED) -> str:
        """Read a text."""
        value = self.get(key, default)
        if not isinstance(value, str):
            self._refuse_type(key, value, "a text in quotes", f'"{key}"')
        return value

    def table(self, key: str, default: Any = REQUIRED) -> Table:
        """Read a table inside this one."""
        value = self.get(key, default)
        path = f"{self.path}.{key}" if self.path else key
        if isinstance(value, list | tuple) and not self.path:
            self.refuse(
                key,
                f"There can be only one [{key}].",
                f"{show(value)} is a list",
                f"[[{key}]] makes a list, [{key}] a single table",
                f"write the heading as [{key}]",
            )
        return Table(value, self.source, path)

    def tables(self, key: str, default: Any = ()) -> list[Table]:
        """Read a list of tables, written [[key]] at the top level."""
        value = self.get(key, default)
        if isinstance(value, Mapping):
            heading = f"write the heading as [[{key}]]" if not self.path else f"write {key} = [{{ ... }}]"
            self.refuse(
                key,
                f"{key} must be a list of tables.",
                f"{show(dict(value))} is a single table",
                "brackets are missing: double ones make a list of tables",
                heading,
            )
        if not isinstance(value, list | tuple):
            self._refuse_type(key, value, "a list of tables", f"[[{key}]]" if not self.path else "[{ ... }]")
        path = f"{self.path}.{key}" if self.path else key
        return [Table(entry, self.source, f"{path}[{i}]") for i, entry in enumerate(value)]

    def _refuse_type(self, key: str, value: object, expected: str, example: str) -> NoReturn:
        self.refuse(
            key,
            f"{key} has the wrong type.",
            f"{show(value)} is {_kind(value)}; {expected} is expected",
            "a value of another type was written",
            f"write {key} = {example}" if "[" not in key else f"write {example}",
        )


def _kind(value: object) -> str:
    """Name the type of a TOML value in plain words."""
    kinds: list[tuple[Any, str]] = [
        (bool, "true or false"),
        (Integral, "a whole number"),
        (Real, "a number"),
        (str, "a text"),
        (Mapping, "a table"),
        ((list, tuple, np.ndarray), "a list"),
    ]
    return next((words for types, words in kinds if isinstance(value, types)), f"a {type(value).__name__}")
