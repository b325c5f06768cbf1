"""What the commands on data sets share: options, data behind the gate, folders to write to."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

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
    from surrogate.dataset import load
    from surrogate.gate import UNVALIDATED, ask
    from surrogate.problem import problem_of

    problem = problem_of(load(directory))
    valid = ask(allow_unvalidated=True)
    if problem.certificate in (UNVALIDATED, valid.id) and (
        allow_unvalidated or problem.certificate != UNVALIDATED
    ):
        return problem
    if allow_unvalidated:
        from dataclasses import replace

        return replace(problem, certificate=UNVALIDATED)
    from ancf.errors import Message

    message = Message(
        "The certificate of these data is not valid.",
        str(directory),
        f"the data have {problem.certificate}, valid now is {valid.id}",
        "data made with --allow-unvalidated, or code that changed since they were made",
        "make the data again, or add --allow-unvalidated: the stamp goes into model and card",
    )
    print(message, file=sys.stderr)
    raise typer.Exit(NOT_VALIDATED)


class Writing:
    """Make a folder; a failure of the file system while writing becomes a message."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __enter__(self) -> Path:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            self.__exit__(OSError, error, None)
        return self.folder

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        if isinstance(error, OSError):
            refuse(
                "The results cannot be written.", str(self.folder), str(error),
                "a full disk, a missing permission, or a file in the place of the folder",
            )  # fmt: skip


def refuse(what: str, where: str, value: str, cause: str) -> NoReturn:
    """Raise `InputError` about an argument or a folder."""
    from ancf.errors import InputError, Message

    raise InputError(Message(what, where, value, cause, "see the --help of the command"))
