"""Messages for people: what happened, where, value and limit, likely cause, what to try."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn


@dataclass(frozen=True)
class Message:
    """The five parts of every message that leaves the program (interface.md, "One command")."""

    what: str
    where: str
    value: str
    cause: str
    advice: str

    def __str__(self) -> str:
        labels = ("where: ", "value: ", "cause: ", "try:   ")
        parts = (self.where, self.value, self.cause, self.advice)
        return "\n  ".join([self.what, *(label + part for label, part in zip(labels, parts, strict=True))])


class InputError(ValueError):
    """The input is wrong: nothing was computed and nothing written (exit code 2)."""

    def __init__(self, message: Message) -> None:
        super().__init__(str(message))
        self.message = message


def refuse(what: str, where: str, value: str, cause: str, advice: str) -> NoReturn:
    """Raise an `InputError` of these five parts."""
    raise InputError(Message(what, where, value, cause, advice))


class SceneError(InputError):
    """A scene file, or one of its values, cannot be used."""
