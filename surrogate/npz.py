"""Arrays in an .npz file: equal arrays give equal bytes, a file is there whole or not at all.

Uncompressed, members in alphabetical order, every time stamp the first of 1980 (the oldest that zip knows).
"""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surrogate.whole_file import write_bytes

EPOCH = (1980, 1, 1, 0, 0, 0)


class DamagedFile(ValueError):
    """A file is not a whole .npz file of arrays without Python objects; the text says why."""


def write(path: Path, arrays: Mapping[str, NDArray]) -> Path:
    """Write arrays; raises OSError with nothing left behind when the disk is full."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_STORED) as archive:
        for name in sorted(arrays):
            member = zipfile.ZipInfo(f"{name}.npy", EPOCH)
            member.create_system = 3  # the same on every system
            member.external_attr = 0o600 << 16
            content = io.BytesIO()
            np.lib.format.write_array(content, _canonical(arrays[name]), version=(1, 0), allow_pickle=False)
            archive.writestr(member, content.getvalue())
    return write_bytes(path, packed.getvalue())


def read(path: Path) -> dict[str, NDArray]:
    """Read all arrays; raises `DamagedFile`, or OSError where the file cannot be opened."""
    try:
        with zipfile.ZipFile(path) as archive:
            return {
                name.removesuffix(".npy"): np.lib.format.read_array(
                    io.BytesIO(archive.read(name)), allow_pickle=False
                )
                for name in archive.namelist()
            }
    except (zipfile.BadZipFile, ValueError, EOFError, NotImplementedError) as error:
        raise DamagedFile(f"{path.name} is truncated or damaged: {error}") from None


def described(array: NDArray) -> dict[str, Any]:
    """Shape, type and digest of an array, as a card holds them."""
    return {"shape": list(array.shape), "dtype": array.dtype.str, "sha256": sha256(array)}


def sha256(array: NDArray) -> str:
    """SHA-256 of the numbers (little-endian, C order), after type and shape."""
    plain = _canonical(array)
    digest = hashlib.sha256(f"{plain.dtype.str} {plain.shape} ".encode())
    digest.update(plain.tobytes())
    return digest.hexdigest()


def _canonical(array: NDArray) -> NDArray:
    plain = np.ascontiguousarray(array)
    plain = plain.reshape(np.shape(array))  # ascontiguousarray makes a row of a single number
    return plain.astype(plain.dtype.newbyteorder("<"), copy=False)
