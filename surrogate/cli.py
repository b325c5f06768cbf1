"""`ancf dataset`. Light at import: everything heavy is loaded when the command runs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from surrogate.design import Design

NOT_VALIDATED = 4  # exit code of interface.md


def dataset(
    design: Annotated[
        Path | None, typer.Argument(metavar="[DESIGN.toml]", help="A scene file with a table [design].")
    ] = None,
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Folder for data.npz and card.json.")
    ] = ...,  # type: ignore[assignment]
    preset: Annotated[
        str | None,
        typer.Option("--preset", metavar="paper|sobol", help="A design of our own; default sobol."),
    ] = None,
    allow_unvalidated: Annotated[
        bool,
        typer.Option("--allow-unvalidated", help="Without a valid certificate: stamp the data UNVALIDATED."),
    ] = False,
) -> None:
    """Make an inverse-statics data set: loads and the tip poses that they cause.

    Exit code 0: done. 2: the input is wrong. 4: no valid certificate, or samples outside its domain.
    """
    from surrogate.sweep import make
    from validation.certificate import NotValidated

    try:
        found = make(_design(design, preset), out, allow_unvalidated=allow_unvalidated)
    except NotValidated as error:
        print(error.message, file=sys.stderr)
        raise typer.Exit(NOT_VALIDATED) from None
    print(f"{len(found)} rows, certificate {found.card['certificate']}, written: {out}", file=sys.stderr)


def _design(path: Path | None, preset: str | None) -> Design:
    from surrogate.design import load_design
    from surrogate.design import preset as named

    return load_design(path) if path is not None else named(preset or "sobol")
