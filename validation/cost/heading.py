"""What every output of `ancf cost` begins with: schema, machine, threads, versions."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from validation.environment import environment, threads, versions

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA = 1
PEERS = ("exudyn", "soromox")


def heading(kind: str, targets: Sequence[float]) -> dict[str, Any]:
    """The keys that the JSON objects share; scope and seconds are filled in at the end."""
    return {
        "schema": SCHEMA,
        "kind": kind,
        "scope": "",
        "threads": threads(),
        "environment": environment(),
        "versions": versions() | {name: version(name) for name in PEERS},
        "targets": list(targets),
        "seconds": 0.0,
    }


def version(package: str) -> str:
    """Version of an installed package, else "not installed"."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def print_machine(found: dict[str, Any], console: Console) -> None:
    """Machine, threads and versions in one line."""
    machine = found["environment"]
    console.print(
        f"{machine['processor']}, {machine['cores']} cores; threads: {found['threads']};"
        f" python {found['versions']['python']}, numpy {found['versions']['numpy']}; CPU time of warm solves"
    )
