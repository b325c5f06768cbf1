"""Reading wanted poses: JSON, text or .npy, one pose or many."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from ancf.errors import InputError, Message
from surrogate.inverse import check_poses

Floats = NDArray[np.float64]

COLUMNS = ("position", "r_x", "r_y", "r_z")
# What readers raise at files that hold something else; a header may also ask for more memory than there is.
BROKEN = (
    OSError, EOFError, ValueError, TypeError, KeyError, AttributeError, OverflowError, MemoryError,
    RecursionError,
)  # fmt: skip


def load_poses(path: Path) -> Floats:
    """Poses (B, 3, 4) of a file, columns r [m], r_x, r_y, r_z in structure axes.

    ``.npy``: (3, 4), (n, 3, 4) or (n, 12). ``.json``: the same as lists, {"pose": ..} or {"poses": ..}, or a
    ``result.json`` of ``ancf solve`` (the tip of its first rod). Else text: 3 lines of 4 numbers, or lines of
    12: r, r_x, r_y, r_z one after the other.

    Raises
    ------
    InputError : no such file, not readable, not finite or of another shape.
    """
    try:
        if path.suffix == ".npy":
            values: Any = np.load(path, allow_pickle=False)
        elif path.suffix == ".json":
            values = _of_json(json.loads(path.read_text()))
        else:
            text = path.read_text()
            if not text.strip():
                _refuse(path, "it is empty")
            values = np.loadtxt(text.splitlines(), delimiter="," if "," in text else None, ndmin=2)
        values = np.asarray(values, dtype=float)
    except BROKEN as error:
        _refuse(path, f"{type(error).__name__}: {error}")
    if values.ndim == 2 and values.shape[1] == 12:
        values = np.swapaxes(values.reshape(-1, 4, 3), 1, 2)
    return check_poses(values)


def _of_json(data: Any) -> Any:
    if isinstance(data, dict):
        if "rods" in data:
            tip = next(iter(data["rods"].values()), {})["tip"]
            return np.column_stack([tip[name] for name in COLUMNS])
        return data["poses"] if "poses" in data else data["pose"]
    return data


def _refuse(path: Path, value: str) -> NoReturn:
    raise InputError(
        Message(
            "The poses cannot be read.",
            str(path),
            value,
            "a missing file, another format, or lines of unequal length",
            "give 3 lines of 4 numbers (columns r, r_x, r_y, r_z), lines of 12 numbers, .json or .npy",
        )
    )
