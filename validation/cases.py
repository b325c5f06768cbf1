"""Validation cases: records, and the loader that reads `cases/*.toml` and refuses what is not complete.

One file is one family: a problem, a scene, a reference, limits with reasons; each `[[case]]` changes the
first rod, the load or the parameters. A matrix of cases is written once: `[[vary.AXIS]]` lists what an axis
may be, and every combination is a case named ROW-NAME-NAME. A case without a reason for a limit, or with an
unknown key, is an error.
"""

from __future__ import annotations

import copy
import fnmatch
import itertools
import math
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ancf.errors import InputError, Message
from validation.criteria import Limit

CASES = Path(__file__).parent / "cases"
INDEPENDENCE = {
    "closed form": "a formula, derived again in reference/ without the solver",
    "rod integration": "the Simo-Reissner rod integrated by collocation in reference/, no code in common",
    "section problem": "the three-dimensional continuum, reduced to its section; separate code in reference/",
    "3-D solid": "hexahedra of second order with scikit-fem; separate code and laws in reference/",
    "other code": "numbers published or computed by others",
    "identity": "a property that holds exactly for every correct program; no reference is needed",
    "own earlier number": "a count of our own; it shows change, not truth",
}
FAMILY_KEYS = (
    "row",
    "title",
    "problem",
    "loads",
    "shows",
    "reference",
    "scene",
    "limit",
    "case",
    "parameters",
    "vary",
)
CASE_KEYS = (
    "id",
    "title",
    "loads",
    "shows",
    "set",
    "required",
    "rod",
    "load",
    "parameters",
    "limit",
    "warning",
    "reference",
)
VARIANT_KEYS = ("name", "set", "required", "rod", "load", "parameters", "warning", "reference")
LIMIT_KEYS = ("cases", "quantity", "value", "unit", "reason", "kind", "documented", "spread")
REFERENCE_KEYS = ("name", "independence", "source", "estimated_error", "values", "note")
SETS = ("quick", "full")
KINDS = ("reference", "non-regression")


class CaseError(InputError):
    """A case file cannot be used."""


@dataclass(frozen=True)
class Reference:
    """Where the right answer comes from: name, independence, source, estimated error, printed values."""

    name: str
    independence: str
    source: str
    estimated_error: float = 0.0
    values: Mapping[str, Any] = field(default_factory=dict)
    note: str = ""


@dataclass(frozen=True)
class Case:
    """One case, ready to run; `scene` is a dictionary in the format of a scene file."""

    id: str
    row: str
    family: str  # title that the cases of the file share
    title: str
    problem: str
    loads: str
    shows: str
    set: str
    required: bool
    scene: dict[str, Any]
    parameters: dict[str, Any]
    reference: Reference
    limits: tuple[Limit, ...]
    warning: str = ""  # words that the solver's own warnings must contain
    place: Mapping[str, str] = field(default_factory=dict)  # in a matrix of cases: name on each axis

    @property
    def reproduce(self) -> str:
        """Command that runs this case alone."""
        return f"ancf validate --case {self.id}"

    @property
    def rod(self) -> dict[str, Any]:
        """First rod of the scene."""
        return self.scene["rod"][0]

    @property
    def combinations(self) -> set[tuple[str, str, str]]:
        """Element, formulation and law; several where the parameters vary them."""
        rods = [{**self.rod, **variant} for variant in self.parameters.get("variants", [{}])]
        return {
            (
                rod.get("element", "3333"),
                formulation_of(rod),
                rod.get("material", {}).get("law", "saint-venant-kirchhoff"),
            )
            for rod in rods
        }


def formulation_of(rod: Mapping[str, Any]) -> str:
    """Formulation of a rod table; an element with a quadratic section knows only the continuum."""
    usual = "continuum" if rod.get("element") == "3363" else "enhanced"
    return rod.get("formulation", usual)


def load_cases(folder: Path = CASES) -> list[Case]:
    """Read every family in a folder, in the order of the file names.

    Raises `CaseError` for a folder without cases, a file that is not TOML, unknown or missing keys, a limit
    without reason, and two cases of one name.
    """
    files = sorted(folder.glob("*.toml"))
    cases = [case for file in files for case in _read_family(file)]
    if not cases:
        _refuse(
            "There are no validation cases.",
            str(folder),
            f"{len(files)} files",
            "a folder that is not installed",
        )
    seen: set[str] = set()
    for case in cases:
        if case.id in seen:
            _refuse(f"Two cases are named {case.id}.", str(folder), case.id, "a copied table")
        seen.add(case.id)
    return cases


def _read_family(file: Path) -> list[Case]:
    where = file.name
    try:
        family = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, OSError) as error:
        raise CaseError(
            Message("The case file cannot be read.", where, str(error), "not valid TOML", "correct that line")
        ) from error
    _expect(family, FAMILY_KEYS, where, needed=("row", "title", "problem"))
    listed = [
        _read_case(family, entry, f"{where}, case {i + 1}") for i, entry in enumerate(family.get("case", []))
    ]
    matrix = [_read_case(family, entry, where, place) for entry, place in _combinations(family, where)]
    if not listed + matrix:
        _refuse(
            "The family has no case.", where, "no [[case]], no [[vary.*]]", "an empty family shows nothing"
        )
    for limit in family.get("limit", []):
        pattern = limit.get("cases", "*")
        if not any(fnmatch.fnmatchcase(case.id, pattern) for case in listed + matrix):
            _refuse("A limit is for no case.", where, f"cases = {pattern!r}", "a misspelt name")
    return listed + matrix


def _combinations(family: dict[str, Any], where: str) -> Iterator[tuple[dict[str, Any], dict[str, str]]]:
    """Entry and place of every combination of the axes in `vary`; later axes change what earlier ones set."""
    axes = family.get("vary", {})
    for axis, variants in axes.items():
        for variant in variants:
            _expect(variant, VARIANT_KEYS, f"{where}, vary.{axis}", needed=("name",))
    for chosen in itertools.product(*axes.values()) if axes else ():
        place = {axis: variant["name"] for axis, variant in zip(axes, chosen, strict=True)}
        entry: dict[str, Any] = {"id": "-".join([family["row"], *place.values()])}
        for variant in chosen:
            for key, value in variant.items():
                if key in ("rod", "load", "parameters", "reference"):
                    entry[key] = {**entry.get(key, {}), **value}
                elif key == "set":
                    entry[key] = max(value, entry.get(key, value), key=SETS.index)  # full wins
                elif key != "name":
                    entry[key] = value
        yield entry, place


def _read_case(
    family: dict[str, Any], entry: dict[str, Any], where: str, place: Mapping[str, str] | None = None
) -> Case:
    _expect(entry, CASE_KEYS, where, needed=("id",))
    where = f"{where} ({entry['id']})"
    merged = {key: entry.get(key, family.get(key, "")) for key in ("title", "loads", "shows")}
    for key, value in merged.items():
        if not value:
            _refuse(
                f"The case has no {key}.",
                where,
                "it is empty or missing",
                "every card in the report states it",
            )
    limits = [
        {key: value for key, value in limit.items() if key != "cases"}
        for limit in entry.get("limit", family.get("limit", []))
        if fnmatch.fnmatchcase(entry["id"], limit.get("cases", "*"))
    ]
    if not limits:
        _refuse("The case has no limit.", where, "no [[limit]]", "a case that cannot fail shows nothing")
    if entry.get("set", "quick") not in SETS:
        _refuse("Unknown set.", where, repr(entry["set"]), f"sets are {', '.join(SETS)}")
    return Case(
        id=entry["id"],
        row=family["row"],
        family=family["title"],
        problem=family["problem"],
        set=entry.get("set", "quick"),
        required=bool(entry.get("required", True)),
        scene=_scene(family, entry),
        parameters={**family.get("parameters", {}), **entry.get("parameters", {})},
        reference=_read_reference({**family.get("reference", {}), **entry.get("reference", {})}, where),
        limits=tuple(_read_limit(limit, where) for limit in limits),
        warning=entry.get("warning", ""),
        place=place or {},
        **merged,
    )


def _scene(family: dict[str, Any], entry: dict[str, Any]) -> dict[str, Any]:
    """Scene of the case: the family's, with the case's changes to the first rod and its loads."""
    scene = copy.deepcopy(family.get("scene", {}))
    if scene:
        scene["rod"][0].update(copy.deepcopy(entry.get("rod", {})))
        scene.update(copy.deepcopy(entry.get("load", {})))
        scene["title"] = entry["id"]
    return scene


def _read_reference(data: dict[str, Any], where: str) -> Reference:
    _expect(data, REFERENCE_KEYS, f"{where}, reference", needed=("name", "independence", "source"))
    if data["independence"] not in INDEPENDENCE:
        _refuse(
            "Unknown independence of a reference.", where, repr(data["independence"]),
            f"it is one of: {', '.join(INDEPENDENCE)}",
        )  # fmt: skip
    return Reference(**data)


def _read_limit(data: dict[str, Any], where: str) -> Limit:
    where = f"{where}, limit {data.get('quantity', '')!r}"
    _expect(data, LIMIT_KEYS, where, needed=("quantity", "value", "unit", "reason"))
    value, kind = data["value"], data.get("kind", "reference")
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not (math.isfinite(value) and value > 0.0)
    ):
        _refuse(
            "A limit must be a positive number.",
            where,
            repr(value),
            "a limit of zero cannot be met in float64",
        )
    if not str(data["reason"]).strip():
        _refuse(
            "A limit has no reason.", where, "reason is empty", "a limit nobody can argue with is arbitrary"
        )
    if kind not in KINDS:
        _refuse("Unknown kind of limit.", where, repr(kind), f"it is one of: {', '.join(KINDS)}")
    return Limit(**data)


def _expect(data: Mapping[str, Any], keys: tuple[str, ...], where: str, needed: tuple[str, ...]) -> None:
    unknown = [key for key in data if key not in keys]
    if unknown:
        _refuse(
            f"Unknown key {unknown[0]!r}.", where, ", ".join(unknown), f"valid keys are {', '.join(keys)}"
        )
    missing = [key for key in needed if key not in data]
    if missing:
        _refuse(f"The key {missing[0]!r} is missing.", where, ", ".join(missing), "the case is not complete")


def _refuse(what: str, where: str, value: str, cause: str) -> None:
    raise CaseError(Message(what, where, value, cause, "correct the file in validation/cases"))
