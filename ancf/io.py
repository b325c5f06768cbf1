"""Result files of a solution: result.json, result.csv, result.vtu and state.npz.

All files are written beside their destination and put in place at the end, each whole or not at all, with
result.json last: while it is missing or old, the set is not complete.
"""

from __future__ import annotations

import csv
import json
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ancf.errors import InputError, Message

if TYPE_CHECKING:
    from ancf.solution import Solution

RESULT_FILES = ("state.npz", "result.csv", "result.vtu", "result.json")  # put in place in this order

CSV_HEADER = (
    ["rod", "at [-]", "x [m]"]
    + [f"position_{a} [m]" for a in "xyz"]
    + [f"force_{a} [N]" for a in "xyz"]
    + [f"moment_{a} [N m]" for a in "xyz"]
    + ["axial_force [N]", "shear_y [N]", "shear_z [N]"]
    + ["torsion [N m]", "bending_about_y [N m]", "bending_about_z [N m]"]
)


def check_folder(path: str | os.PathLike[str]) -> Path:
    """Refuse, before anything is computed, a folder that could not be written (`InputError`)."""
    folder = Path(path)
    existing = next(parent for parent in (folder, *folder.absolute().parents) if parent.exists())
    taken = next((folder / name for name in RESULT_FILES if (folder / name).is_dir()), None)
    if existing.is_dir() and os.access(existing, os.W_OK) and taken is None:
        return folder
    if taken is not None:
        value, cause = f"{taken} is a folder", "the name of a result file is taken by a folder"
    elif existing.is_dir():
        value, cause = f"{existing} may not be written", "missing permission"
    else:
        value, cause = f"{existing} is a file", "the name is taken by a file"
    raise InputError(
        Message(
            "The output folder cannot be used.",
            f"--out {folder}",
            value,
            cause,
            "name a folder, new or existing, that may be written",
        )
    )


def result_text(result: Any) -> str:
    """JSON text of a result; raises ValueError for a number that is not finite, which is a bug."""
    return json.dumps(result, allow_nan=False, indent=1)


def write_result(path: str | os.PathLike[str], solution: Solution) -> dict[str, Any]:
    """Write the files of a solution into a folder and return the content of result.json.

    Parameters
    ----------
    path : folder; created if needed
    solution : converged or not: the state is the last equilibrium found

    Notes
    -----
    result.csv holds section forces and moments at the axial integration points, in SCS and in the axes of the
    turned section. result.vtu needs meshio (extra "pictures"); without it the file is left out, a former one
    is removed, and the result says so among its warnings.
    """
    folder = Path(path)
    folder.mkdir(parents=True, exist_ok=True)
    result = solution.as_dict()
    with tempfile.TemporaryDirectory(dir=folder, prefix=".unfinished-") as name:
        stage = Path(name)
        solution.save(stage / "state.npz")
        _write_csv(stage / "result.csv", solution)
        if not _write_vtu(stage / "result.vtu", solution):
            advice = "result.vtu was not written: it needs meshio, pip install 'ancf[pictures]'"
            result["warnings"] = [*result["warnings"], advice]
        (stage / "result.json").write_text(result_text(result) + "\n", encoding="utf-8")
        for file in RESULT_FILES:
            if (stage / file).exists():
                os.replace(stage / file, folder / file)
            else:
                (folder / file).unlink(missing_ok=True)
    return result


def _write_csv(path: Path, solution: Solution) -> None:
    """Section forces and moments [N, N m] along each rod, one row per axial integration point."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(CSV_HEADER)
        for rod in solution.scene.rods:
            forces = solution.section_forces(rod.name)
            positions = solution.displaced(rod.name, forces.at, np.zeros(1), np.zeros(1))
            for i, axes in enumerate(solution.section_axes(rod.name)):
                numbers = [[forces.at[i], forces.x[i]], positions[i], forces.force[i], forces.moment[i]]
                numbers += [forces.force[i] @ axes, forces.moment[i] @ axes]
                writer.writerow([rod.name, *(repr(float(v)) for v in np.concatenate(numbers))])


def _write_vtu(path: Path, solution: Solution) -> bool:
    """Write the deformed surfaces of all rods; False when meshio is not installed.

    Points are the deformed ones. Data: `displacement` [m] in SCS; `strain` (Green-Lagrange) and `stress`
    (second Piola-Kirchhoff, Pa), both (9,) row by row in axes of the reference section; `rod`, its number.
    """
    try:
        import meshio
    except ModuleNotFoundError:
        return False
    from ancf.surface import rod_surface

    skins = [
        (number, part) for number, rod in enumerate(solution.scene.rods) for part in range(len(rod.parts))
    ]
    surfaces = [rod_surface(solution, solution.scene.rods[number].name, part) for number, part in skins]
    counts = [surface.position[..., 0].size for surface in surfaces]
    first = np.cumsum([0, *counts[:-1]])

    def joined(field: str, width: int) -> np.ndarray:
        return np.concatenate([getattr(surface, field).reshape(-1, width) for surface in surfaces])

    quads = np.concatenate([s.quads + start for s, start in zip(surfaces, first, strict=True)])
    mesh = meshio.Mesh(
        joined("position", 3),
        [("quad", quads)],
        point_data={
            "displacement": joined("displacement", 3),
            "strain": joined("strain", 9),
            "stress": joined("stress", 9),
            "rod": np.repeat([number for number, _ in skins], counts),
        },
    )
    mesh.write(path, file_format="vtu")
    return True
