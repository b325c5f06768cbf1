"""`ancf train` and `ancf track`. Light at import: the rest is loaded when a command runs."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surrogate.cli_data import Allow, Data, Json, problem_of_folder, refuse

if TYPE_CHECKING:
    from surrogate.problem import Problem


def train(
    directory: Data,
    out: Annotated[Path | None, typer.Option("--out", metavar="MODEL", help="Folder; DIR/model.")] = None,
    model: Annotated[
        str, typer.Option("--model", help="equivariant, cnn, mlp or polynomial.")
    ] = "equivariant",
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of the weights and the order of rows.")] = 0,
    epochs: Annotated[int | None, typer.Option("--epochs", min=1, help="Default: 500, or 400.")] = None,
    allow_unvalidated: Allow = False,
    json: Json = False,
) -> None:
    """Train an inverse model: tip pose to tip moment.

    Writes model.safetensors, model.json, MODEL_CARD.md and model.onnx. Scores are errors of the
    tip when the moments are solved again, on poses that know nothing of the training design.

    Exit code 0: done. 2: the input is wrong. 4: the certificate of the data is not the valid one.
    """
    from surrogate.fit import KINDS
    from surrogate.whole_file import writing

    if model not in KINDS:
        refuse("There is no such model.", f"--model {model}", f"one of {', '.join(KINDS)}", "a misspelt name")
    problem = problem_of_folder(directory, allow_unvalidated)
    with writing(out or directory / "model") as folder:
        record = train_and_save(problem, folder, model, seed, epochs)
    if json:
        from ancf.io import result_text

        print(result_text(record))
    else:
        from surrogate.model_card import model_card

        print(model_card(record), file=sys.stderr)
    print(f"written: {folder}", file=sys.stderr)


def train_and_save(
    problem: Problem, folder: Path, kind: str, seed: int = 0, epochs: int | None = None
) -> dict[str, Any]:
    """Fit one model, measure it on all sets of poses, calibrate its radius, write its folder."""
    from surrogate.conformal import calibrated, calibration
    from surrogate.evaluate import LeakWarning, designs, latency, leak_guard, score, slab_score
    from surrogate.fit import fit
    from surrogate.model_card import model_card
    from surrogate.model_file import CARD, GRAPH, save
    from surrogate.problem import plain_tables
    from surrogate.whole_file import write_text

    fitted = fit(problem, kind, [seed], epochs)
    (found,) = fitted.models
    scores = {
        name: score(found.predict, problem.arm, samples, problem.deviation)
        for name, samples in designs(problem).named().items()
    }
    scores["slab"] = slab_score(problem, kind, seed, epochs)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LeakWarning)
        leak = leak_guard(scores["split"], scores["off_grid"], kind)
    if leak:
        print(f"warning: {leak}", file=sys.stderr)
    p50, p99 = latency(found.predict, problem.test.poses)
    rod = problem.arm.rod
    record = {
        "data": problem.name,
        "certificate": problem.certificate,
        "scene": plain_tables(problem.tables),
        "frame": problem.arm.moment.frame,
        "arm": f"length {rod.length:g} m, {rod.section}, {rod.material}, {rod.elements} x {rod.element}",
        "moment_range": problem.bounds.tolist(),
        "training": {"rows": len(problem.train), "seed": seed, "cpu_seconds": fitted.seconds},
        "scores": {name: s.as_dict() for name, s in scores.items()},
        "error_radius": calibrated(found.predict, problem.arm, calibration(problem)).as_dict(),
        "leak": leak,
        "latency": {"p50": p50, "p99": p99},
    }
    if fitted.training_loss is not None and fitted.validation_loss is not None:
        record["training_loss"] = fitted.training_loss[0].tolist()
        record["validation_loss"] = fitted.validation_loss[0].tolist()
    record = save(folder, found, record)
    write_text(folder / CARD, model_card(record))
    try:
        from surrogate.onnx_graph import write_onnx

        write_onnx(found, folder / GRAPH)
    except ModuleNotFoundError:
        print("no model.onnx: the package onnx is not installed", file=sys.stderr)
    return record


def track(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Folder of a model (`ancf train`).")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Moments and poses as .json.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Figure (.png, .svg, .pdf).")
    ] = None,
    json: Json = False,
) -> None:
    """Follow the reference trajectory of the paper (eq. 47-48, fig. 9 and 10) with a model, through ANCF.

    Exit code 0: done. 2: the input is wrong. 3: some moments have no equilibrium.
    """
    from ancf.cli import NO_EQUILIBRIUM
    from ancf.io import result_text
    from surrogate.model_file import load_model
    from surrogate.tracking import track as follow
    from surrogate.whole_file import write_text, writing

    if plot is not None:
        from ancf.view import check_picture_path

        check_picture_path(plot)
    found = follow(load_model(model))
    record = {"schema": 1, "model": str(model), **found.as_dict()}
    if out is not None:
        with writing(out.parent):
            write_text(out, result_text(record) + "\n")
    if plot is not None:
        from surrogate.figures import save_figure
        from surrogate.figures_paper import tracking

        with writing(plot.parent):
            save_figure(tracking(found), plot, found.certificate)
    if json:
        print(result_text(record))
    else:
        tip, angle = record["tip_percent"], record["angle_degrees"]
        print(
            f"{len(found.wanted)} poses; tip error mean {tip['mean']:.3g}, p95 {tip['p95']:.3g},"
            f" max {tip['max']:.3g} % of the length; {angle['mean']:.3g} degrees; the exact inverse comes"
            f" within {record['exact_tip_percent']['mean']:.3g} %; certificate: {record['certificate']}",
            file=sys.stderr,
        )
    if found.unsolved:
        raise typer.Exit(NO_EQUILIBRIUM)
