"""Files that are there whole or not at all, and one message for a disk that does not take them."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ancf.errors import InputError, Message


def write_bytes(path: Path, content: bytes) -> Path:
    """Write a file through a temporary one beside it, which the disk has taken before the name is given."""
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise
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
