"""`ancf invert`. Light at import: everything heavy is loaded when the command runs."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ancf.cli import NO_EQUILIBRIUM

if TYPE_CHECKING:
    from surrogate.arm import Arm
    from surrogate.inverse import Inverse


def invert(
    model: Annotated[
        Path,
        typer.Argument(metavar="MODEL", help="A scene file (no model needed), or the folder of a model."),
    ],
    pose: Annotated[Path, typer.Option("--pose", metavar="FILE", help="Wanted poses: text, .json, .npy.")],
    exact: Annotated[
        bool, typer.Option("--exact", help="Search on the equilibria alone; the model only names the arm.")
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Find the tip moments for wanted tip poses.

    With the folder of a model (`ancf train`): its answer, then steps through the exact sensitivities until
    the tip does not move. With a scene file, or --exact: the same search from the closed form of the thin
    arm.

    JSON: {schema, model, method, certificate, frame, length, error_radius, warnings, seconds, poses[]},
    poses[] = {moment [N m], status (converged | not_converged), reachable, reason, position_mismatch [m],
    rotation_mismatch [rad], steps, solves, pose, predicted [N m]}. Mismatches are between the wanted pose and
    the equilibrium under the moment; `error_radius` (null without a model) is of `predicted`, the model's
    answer before any step.

    Exit code 0: answered; whether a pose is reachable is part of the answer. 2: the input is wrong.
    3: the search did not end for some pose.
    """
    import numpy as np

    from ancf.io import result_text
    from ancf.scene_file import load_scene
    from surrogate.arm import Arm
    from surrogate.inverse import exact_inverse
    from surrogate.model_file import load_model
    from surrogate.pose_file import load_poses

    wanted = load_poses(pose)
    if model.is_dir():
        loaded = load_model(model)
        arm, bounds, stamp = loaded.arm, loaded.bounds, loaded.record["certificate"]
    else:
        loaded, arm, bounds, stamp = None, Arm.of(load_scene(model)), None, None
    arm.solve(arm.moments(np.array([[0.0, 0.0, 0.1]])))  # loading the kernel is no part of the answer
    started = time.perf_counter()
    predicted = None if loaded is None or exact else loaded.model.predict(wanted)
    trained = {} if loaded is None or exact else loaded.record
    found = exact_inverse(arm, wanted, guess=predicted, bounds=bounds)
    seconds = time.perf_counter() - started
    record = {
        "schema": 1,
        "model": str(model),
        "method": f"{trained['kind']}, gauss-newton" if trained else "levenberg-marquardt",
        "certificate": stamp,
        "error_radius": trained.get("error_radius"),
        "warnings": [trained["leak"]] if trained.get("leak") else [],
        **answers(arm, found),
        "seconds": seconds,
    }
    for answer, row in zip(record["poses"], predicted if predicted is not None else (), strict=False):
        answer["predicted"] = row.tolist()
    if json:
        print(result_text(record))
    else:
        _show(record)
    if not found.converged.all():
        raise typer.Exit(NO_EQUILIBRIUM)


def answers(arm: Arm, found: Inverse) -> dict[str, Any]:
    """The answers as a record for JSON."""
    return {
        "frame": arm.moment.frame,
        "length": arm.length,
        "poses": [
            {
                "moment": found.moments[row].tolist(),
                "status": "converged" if found.converged[row] else "not_converged",
                "reachable": bool(found.reachable[row]),
                "reason": found.reason(row),
                "position_mismatch": float(found.position_mismatch[row]),
                "rotation_mismatch": float(found.rotation_mismatch[row]),
                "steps": int(found.steps[row]),
                "solves": int(found.solves[row]),
                "pose": found.poses[row].tolist(),
            }
            for row in range(len(found.moments))
        ],
    }


def _show(record: dict[str, Any]) -> None:
    from rich.console import Console

    console = Console(stderr=True, highlight=False, markup=False, width=None if sys.stderr.isatty() else 200)
    for number, answer in enumerate(record["poses"]):
        moment = ", ".join(f"{value:.6g}" for value in answer["moment"])
        state = "reachable" if answer["reachable"] else f"not reachable: {answer['reason']}"
        console.print(f"pose {number}: moment ({moment}) N m ({record['frame']} axes), {state}")
        console.print(
            f"  mismatch {answer['position_mismatch'] / record['length']:.2e} of the length,"
            f" {answer['rotation_mismatch']:.2e} rad; {answer['steps']} steps, {answer['solves']} solves"
        )
    if record["error_radius"] is not None:
        from surrogate.conformal import radius_text

        radius = record["error_radius"]
        console.print(
            f"error radius of the model alone in {100 * radius['level']:g} of 100 cases:"
            f" {radius_text(radius)}; certificate: {record['certificate']}"
        )
    for warning in record["warnings"]:
        console.print(f"warning: {warning}")
    console.print(f"{record['method']}, {1e3 * record['seconds'] / len(record['poses']):.2g} ms a pose")
