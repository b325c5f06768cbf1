"""Digests of what a certificate depends on: files byte by byte, cases by what they ask, content as JSON."""

from __future__ import annotations

import hashlib
import importlib.util
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from validation.cases import Case

PACKAGE = Path(__file__).parent
# Of validation/ the page and the commands show verdicts; everything else makes them.
SHOWING = ("report", "cli.py")
CASE_CONTENT = ("problem", "required", "set", "scene", "parameters", "warning")
LIMIT_CONTENT = ("quantity", "value", "unit", "kind", "documented", "spread")


@dataclass(frozen=True)
class Roots:
    """Where the three packages lie that a certificate speaks about."""

    ancf: Path = field(default_factory=lambda: _home("ancf"))
    reference: Path = field(default_factory=lambda: _home("reference"))
    validation: Path = PACKAGE

    @property
    def cases(self) -> Path:
        """Folder of the case files."""
        return self.validation / "cases"


def sha256(data: bytes) -> str:
    """SHA-256 in hexadecimal digits."""
    return hashlib.sha256(data).hexdigest()


def of_json(content: Any) -> str:
    """SHA-256 of the content as canonical JSON: sorted keys, shortest exact floats."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False, default=_plain)
    return sha256(text.encode())


def of_solver(roots: Roots) -> dict[str, str]:
    """Every file of ancf/ by name."""
    return _files(roots.ancf, "ancf")


def of_judges(roots: Roots) -> dict[str, str]:
    """Every file of reference/ and validation/ that makes a verdict, by name.

    Stored results (reference/solved) are numbers that the digested code gives again; cases are digested by
    content, so that a better title changes nothing.
    """

    def stored(inside: Path) -> bool:
        return inside.parts[0] == "solved" and inside.suffix == ".json"

    def shown(inside: Path) -> bool:
        case = inside.parts[0] == "cases" and inside.suffix == ".toml"
        return case or inside.parts[0] in SHOWING or inside.as_posix() == "certificate.json"

    reference = _files(roots.reference, "reference", stored)
    return {**reference, **_files(roots.validation, "validation", shown)}


def of_case(case: Case) -> str:
    """What a case asks: problem, scene, parameters, limits, printed reference values; not its wording."""
    content: dict[str, Any] = {name: getattr(case, name) for name in CASE_CONTENT}
    content["limits"] = [{name: getattr(limit, name) for name in LIMIT_CONTENT} for limit in case.limits]
    reference = asdict(case.reference)
    content["reference"] = {name: reference[name] for name in ("independence", "estimated_error", "values")}
    return of_json(content)


def differences(then: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Which names changed, were added or are missing now."""
    found = [f"{name} changed" for name in sorted(then.keys() & now.keys()) if then[name] != now[name]]
    found += [f"{name} was added" for name in sorted(now.keys() - then.keys())]
    return found + [f"{name} is missing" for name in sorted(then.keys() - now.keys())]


def _files(folder: Path, name: str, ignored: Callable[[Path], bool] = lambda inside: False) -> dict[str, str]:
    """Digest of every file below a folder, byte by byte; a link by where it leads.

    Compiled files are left out: Python makes them anew from the source, unless somebody forges them.
    """
    found = {}
    for path in sorted(folder.rglob("*")):
        inside = path.relative_to(folder)
        if "__pycache__" in inside.parts or ignored(inside):
            continue
        if path.is_symlink():
            found[f"{name}/{inside.as_posix()}"] = sha256(f"link to {path.resolve()}".encode())
        elif path.is_file():
            found[f"{name}/{inside.as_posix()}"] = sha256(path.read_bytes())
    return found


def _home(package: str) -> Path:
    """Folder from which a package is really imported."""
    spec = importlib.util.find_spec(package)
    return Path(spec.origin).parent if spec is not None and spec.origin else PACKAGE.parent / package


def _plain(value: Any) -> Any:
    """Arrays and numpy scalars as plain numbers."""
    return value.tolist()
