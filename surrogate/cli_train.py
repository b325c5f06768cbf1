"""`ancf train`, `crossval`, `track`, `reproduce`. Light at import: the rest is loaded when a command runs."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

if TYPE_CHECKING:
    from surrogate.problem import Problem

NOT_VALIDATED = 4  # exit code of interface.md

Data = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a data set (`ancf dataset`).")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")]
Allow = Annotated[
    bool, typer.Option("--allow-unvalidated", help="Take data without a valid certificate; the stamp stays.")
]


def train(
    directory: Data,
    out: Annotated[Path | None, typer.Option("--out", metavar="MODEL", help="Folder; DIR/model.")] = None,
    model: Annotated[str, typer.Option("--model", help="equivariant, cnn or polynomial.")] = "equivariant",
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

    if model not in KINDS:
        _refuse(
            "There is no such model.", f"--model {model}", f"one of {', '.join(KINDS)}", "a misspelt name"
        )
    problem = _problem(directory, allow_unvalidated)
    with _writing(out or directory / "model") as folder:
        record = train_and_save(problem, folder, model, seed, epochs)
    if json:
        from ancf.io import result_text

        print(result_text(record))
    else:
        from surrogate.model_card import model_card

        print(model_card(record))
    print(f"written: {folder}", file=sys.stderr)


def train_and_save(
    problem: Problem, folder: Path, kind: str, seed: int = 0, epochs: int | None = None
) -> dict[str, Any]:
    """Fit one model, measure it on all sets of poses, calibrate its radius, write its folder."""
    from surrogate.conformal import calibrated
    from surrogate.evaluate import LeakWarning, designs, latency, leak_guard, score, slab_score
    from surrogate.fit import fit
    from surrogate.model_card import model_card
    from surrogate.model_file import CARD, GRAPH, save
    from surrogate.problem import plain_tables

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
        "error_radius": calibrated(found.predict, problem.arm, problem.validation).as_dict(),
        "leak": leak,
        "latency": {"p50": p50, "p99": p99},
    }
    if fitted.training_loss is not None and fitted.validation_loss is not None:
        record["training_loss"] = fitted.training_loss[0].tolist()
        record["validation_loss"] = fitted.validation_loss[0].tolist()
    record = save(folder, found, record)
    (folder / CARD).write_text(model_card(record))
    try:
        from surrogate.onnx_graph import write_onnx

        write_onnx(found, folder / GRAPH)
    except ModuleNotFoundError:
        print("no model.onnx: the package onnx is not installed", file=sys.stderr)
    return record


def crossval(
    directory: Data,
    seeds: Annotated[int, typer.Option("--seeds", min=1, help="Seeds; each trains all 25 networks.")] = 1,
    largest: Annotated[
        float | None,
        typer.Option("--range", help="Solve the design again with its largest moment at this many E I/L."),
    ] = None,
    epochs: Annotated[int, typer.Option("--epochs", min=1)] = 100,
    allow_unvalidated: Allow = False,
    json: Json = False,
) -> None:
    """Regenerate table 1 of the paper: five networks, five folds, beside the published values.

    Errors are mean squared errors on the rows left out, in units of which the largest moment has 20.

    Exit code 0: done. 2: the input is wrong. 4: the certificate of the data is not the valid one.
    """
    from surrogate.crossval import cross_validate, rescaled

    problem = _problem(directory, allow_unvalidated)
    if largest is not None:
        if not 0.0 < largest < 3.5:
            _refuse(
                "The range is not one.", f"--range {largest:g}", "must be between 0 and 3.5 E I/L", "a unit"
            )
        problem = rescaled(problem, largest)
    record = cross_validate(problem, seeds=range(seeds), epochs=epochs).as_dict()
    if json:
        from ancf.io import result_text

        print(result_text({"schema": 1, **record}))
        return
    print(
        "model                        size  MSE (deviation)   published  ratio    N^2 m^2   z-units      R^2"
    )
    for row in record["models"]:
        print(
            f"{row['model']:<27}{row['size']:>6}{row['mse_mean']:>8.3g} ({row['mse_deviation']:.2g})"
            f"{row['published_mse']:>13.3g}{row['ratio']:>7.2f}{row['mse_N2m2']:>11.2e}{row['mse_z']:>10.2e}"
            f"{row['r2']:>9.5f}"
        )
    print(
        f"{record['trainings']} trainings in {record['cpu_seconds']:.1f} s of one core; 20 units are"
        f" {record['range_EI_by_L']:.3g} E I/L; rank correlation with the published errors"
        f" {record['rank_correlation']:.2f}; certificate: {record['certificate']}"
    )


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

    if plot is not None:
        from ancf.view import check_picture_path

        check_picture_path(plot)
    found = follow(load_model(model))
    record = {"schema": 1, "model": str(model), **found.as_dict()}
    if out is not None:
        with _writing(out.parent):
            out.write_text(result_text(record) + "\n")
    if plot is not None:
        from surrogate.figures import save_figure
        from surrogate.figures_paper import tracking

        with _writing(plot.parent):
            save_figure(tracking(found), plot, found.certificate)
    if json:
        print(result_text(record))
    else:
        tip, angle = record["tip_percent"], record["angle_degrees"]
        print(
            f"{len(found.wanted)} poses; tip error mean {tip['mean']:.3g}, p95 {tip['p95']:.3g},"
            f" max {tip['max']:.3g} % of the length; {angle['mean']:.3g} degrees; the exact inverse comes"
            f" within {record['exact_tip_percent']['mean']:.3g} %; certificate: {record['certificate']}"
        )
    if found.unsolved:
        raise typer.Exit(NO_EQUILIBRIUM)


def compare(
    directory: Data,
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Folder; DIR/compare.")] = None,
    seeds: Annotated[int, typer.Option("--seeds", min=1, help="Trainings of each network.")] = 5,
    epochs: Annotated[int | None, typer.Option("--epochs", min=1, help="Shorter trainings.")] = None,
    allow_unvalidated: Allow = False,
    json: Json = False,
) -> None:
    """Compare closed form, polynomial, radial basis functions, the paper's CNN and the equivariant network.

    On test rows, an independent design, a slab left out, the reference trajectory, disturbed poses and
    moments beyond the box; error radius, reachability, and solves that each saves. Writes compare.json and
    compare.md.

    Exit code 0: done. 2: the input is wrong. 4: the certificate of the data is not the valid one.
    """
    from ancf.io import result_text
    from surrogate.compare import compare as measure
    from surrogate.compare import report
    from surrogate.evaluate import LeakWarning

    problem = _problem(directory, allow_unvalidated)
    with _writing(out or directory / "compare") as folder:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LeakWarning)  # it stands in the report
            record = measure(problem, range(seeds), epochs)
        text = report(record)
        (folder / "compare.json").write_text(result_text(record) + "\n")
        (folder / "compare.md").write_text(text)
    print(result_text(record) if json else text)
    print(f"written: {folder}", file=sys.stderr)


def reproduce(
    directory: Data,
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Folder; DIR/paper.")] = None,
    allow_unvalidated: Allow = False,
    json: Json = False,
) -> None:
    """Regenerate figures 4 to 11 and table 1 of the paper from a data set (`--preset paper`).

    Writes fig4.png .. fig11.png, reproduction.json and reproduction.md, with the published values beside ours
    and an explanation of each deviation. Trains the main CNN, then all 25 networks of the table.

    Exit code 0: done. 2: the input is wrong. 4: the certificate of the data is not the valid one.
    """
    from ancf.io import result_text
    from surrogate.reproduce import report
    from surrogate.reproduce import reproduce as regenerate

    problem = _problem(directory, allow_unvalidated)
    with _writing(out or directory / "paper") as folder:
        record = regenerate(problem, folder)
        text = report(record)
        (folder / "reproduction.json").write_text(result_text(record) + "\n")
        (folder / "reproduction.md").write_text(text)
    print(result_text(record) if json else text)
    print(f"written: {folder}", file=sys.stderr)


def _problem(directory: Path, allow_unvalidated: bool) -> Problem:
    """The problem of a folder, if its certificate is the one that is valid now."""
    from surrogate.dataset import load
    from surrogate.gate import UNVALIDATED, ask
    from surrogate.problem import problem_of

    problem = problem_of(load(directory))
    valid = ask(allow_unvalidated=True)
    if problem.certificate in (UNVALIDATED, valid.id) and (
        allow_unvalidated or problem.certificate != UNVALIDATED
    ):
        return problem
    if allow_unvalidated:
        from dataclasses import replace

        return replace(problem, certificate=UNVALIDATED)
    from ancf.errors import Message

    message = Message(
        "The certificate of these data is not valid.",
        str(directory),
        f"the data have {problem.certificate}, valid now is {valid.id}",
        "data made with --allow-unvalidated, or code that changed since they were made",
        "make the data again, or add --allow-unvalidated: the stamp goes into model and card",
    )
    print(message, file=sys.stderr)
    raise typer.Exit(NOT_VALIDATED)


class _writing:
    """Make a folder; a failure of the file system while writing becomes a message."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __enter__(self) -> Path:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            self.__exit__(OSError, error, None)
        return self.folder

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        if isinstance(error, OSError):
            _refuse(
                "The results cannot be written.", str(self.folder), str(error),
                "a full disk, a missing permission, or a file in the place of the folder",
            )  # fmt: skip


def _refuse(what: str, where: str, value: str, cause: str) -> NoReturn:
    from ancf.errors import InputError, Message

    raise InputError(Message(what, where, value, cause, "see ancf train --help"))
