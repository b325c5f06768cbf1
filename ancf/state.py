"""Save and resume: the nodal state of a solution as .npz, written whole or not at all."""

from __future__ import annotations

import hashlib
import os
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ancf.errors import InputError, Message
from ancf.solver import NO_START, prepare, solve

if TYPE_CHECKING:
    from ancf.model import Model
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
                layout=_layout(solution.model),
            )
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def resume(scene: Scene, path: str | os.PathLike[str]) -> Solution:
    """Solve a scene from a saved state.

    Raises `InputError` when the file cannot be read or its rods, elements and meshes are not those of the
    scene, and for a scene that asks for an `accuracy`, which has no mesh.
    """
    if scene.solver.accuracy is not None:
        raise InputError(NO_START)
    try:
        with np.load(path, allow_pickle=False) as data:
            schema, q, layout = int(data["schema"]), np.asarray(data["q"], float), str(data["layout"])
    except (OSError, EOFError, ValueError, KeyError, TypeError, AttributeError, zipfile.BadZipFile) as error:
        raise InputError(
            Message(
                "The state cannot be read.",
                str(path),
                str(error) or type(error).__name__,
                "not a state file, or cut short",
                "solve the scene again and save its state",
            )
        ) from error
    model = prepare(scene)
    if schema != SCHEMA or layout != _layout(model) or q.shape != (model.n,) or not np.isfinite(q).all():
        raise InputError(
            Message(
                "The state does not belong to this scene.",
                str(path),
                f"state: {layout}; scene: {_layout(model)}",
                "rods, elements, meshes, bases or reference shapes differ",
                "resume only scenes that differ in loads, materials or sections",
            )
        )
    return solve(scene, start=q)


def _layout(model: Model) -> str:
    """What nodal coordinates mean: rods, elements and reference positions, by a digest of the latter."""
    rods = "; ".join(f"{rod.rod.name}: {rod.rod.elements} x {rod.element.name}" for rod in model.rods)
    rods += "".join(f"; joint {j.kind} {j.axis}: {', '.join(map(str, j.places))}" for j in model.scene.joints)
    rods += "".join(f"; along {j.along.tolist()}" for j in model.scene.joints if len(j.along) < 3)
    rods += f"; {len(model.scene.controlled_tendons)} tendons of given length" * model.scene.constrained
    reference = np.round(model.q0 / model.unit, 9) + 0.0  # + 0.0: no negative zeros
    return f"{rods}; reference {hashlib.sha256(reference.tobytes()).hexdigest()[:12]}"
