"""Files that are there whole or not at all, and one message for a disk that does not take them."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from ancf.errors import InputError, Message


def write_together(contents: Mapping[Path, bytes]) -> None:
    """Write files that belong together: the disk has taken all of them before one replaces an old one."""
    waiting: dict[Path, str] = {}
    try:
        for path, content in contents.items():
            handle, waiting[path] = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
            with os.fdopen(handle, "wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(waiting[path], 0o644)
        for path in contents:
            os.replace(waiting[path], path)
            del waiting[path]
    finally:
        for temporary in waiting.values():
            os.unlink(temporary)


def write_bytes(path: Path, content: bytes) -> Path:
    """Write one file."""
    write_together({path: content})
    return path


def write_text(path: Path, text: str) -> Path:
    """`write_bytes` of a text in UTF-8."""
    return write_bytes(path, text.encode())


@contextmanager
def writing(folder: Path) -> Iterator[Path]:
    """Make a folder; an error of the disk, then or inside, becomes an `InputError`. Finished files stay."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield folder
    except OSError as error:
        raise InputError(
            Message(
                "The results cannot be written.",
                str(error.filename or folder),
                error.strerror or str(error),
                "a full disk, a missing permission, or a file in the place of the folder",
                "make room and run the same command again: what is finished is kept and nothing is lost",
            )
        ) from error
