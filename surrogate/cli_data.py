"""What the commands on data sets share: options, and data behind the gate."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

if TYPE_CHECKING:
    from surrogate.problem import Problem

NOT_VALIDATED = 4  # exit code of interface.md

Data = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a data set (`ancf dataset`).")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")]
Allow = Annotated[
    bool, typer.Option("--allow-unvalidated", help="Take data without a valid certificate; the stamp stays.")
]


def problem_of_folder(directory: Path, allow_unvalidated: bool) -> Problem:
    """The problem of a folder, if its certificate is the one that is valid now."""
    from dataclasses import replace

    from surrogate.dataset import load
    from surrogate.gate import admit
    from surrogate.problem import problem_of
    from validation.certificate import NotValidated

    problem = problem_of(load(directory))
    try:
        stamp = admit(problem.certificate, str(directory), allow_unvalidated)
    except NotValidated as error:
        print(error.message, file=sys.stderr)
        raise typer.Exit(NOT_VALIDATED) from None
    return replace(problem, certificate=stamp)


def refuse(what: str, where: str, value: str, cause: str) -> NoReturn:
    """Raise `InputError` about an argument or a folder."""
    from ancf.errors import InputError, Message

    raise InputError(Message(what, where, value, cause, "see the --help of the command"))
