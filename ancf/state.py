"""Save and resume: the nodal state of a solution as .npz, written whole or not at all."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ancf.errors import InputError, Message
from ancf.solver import solve

if TYPE_CHECKING:
    from ancf.scene import Scene
    from ancf.solution import Solution

SCHEMA = 1


def save_state(path: str | os.PathLike[str], solution: Solution) -> None:
    """Write q, load factor and the layout that it belongs to."""
    target = Path(path)
    temporary = target.with_name(f".{target.name}.{os.getpid()}.tmp")
    try:
        with temporary.open("wb") as file:
            np.savez(
                file,
                schema=SCHEMA,
                q=solution.q,
                load_factor=solution.load_factor,
                status=str(solution.status),
                layout=_layout(solution.scene),
            )
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def resume(scene: Scene, path: str | os.PathLike[str]) -> Solution:
    """Solve a scene from a saved state.

    Raises `InputError` when the file cannot be read or its rods, elements and meshes are not those of the
    scene.
    """
    try:
        with np.load(path, allow_pickle=False) as data:
            schema, q, layout = int(data["schema"]), data["q"], str(data["layout"])
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        raise InputError(
            Message(
                "The state cannot be read.", str(path), str(error), "not a state file, or cut short",
                "solve the scene again and save its state",
            )
        ) from error  # fmt: skip
    if schema != SCHEMA or layout != _layout(scene):
        raise InputError(
            Message(
                "The state does not belong to this scene.",
                str(path),
                f"state: {layout}; scene: {_layout(scene)}",
                "rods, elements or element types differ",
                "resume only scenes that differ in loads, materials or sections",
            )
        )
    return solve(scene, start=np.array(q, dtype=float))


def _layout(scene: Scene) -> str:
    return "; ".join(f"{rod.name}: {rod.elements} x {rod.element}" for rod in scene.rods)
