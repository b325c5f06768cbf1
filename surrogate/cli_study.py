"""`ancf crossval`, `compare`, `reproduce`, `study`. Light at import: the rest loads when a command runs."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Annotated, Any

import typer

from surrogate.cli_data import NOT_VALIDATED, Allow, Data, Json, problem_of_folder, refuse


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

    problem = problem_of_folder(directory, allow_unvalidated)
    if largest is not None:
        if not 0.0 < largest < 3.5:
            refuse(
                "The range is not one.", f"--range {largest:g}", "must be between 0 and 3.5 E I/L", "a unit"
            )
        problem = rescaled(problem, largest)
    record = cross_validate(problem, seeds=range(seeds), epochs=epochs).as_dict()
    head = (
        "model                        size  MSE (deviation)   published  ratio    N^2 m^2   z-units      R^2"
    )
    rows = [
        f"{row['model']:<27}{row['size']:>6}{row['mse_mean']:>8.3g} ({row['mse_deviation']:.2g})"
        f"{row['published_mse']:>13.3g}{row['ratio']:>7.2f}{row['mse_N2m2']:>11.2e}{row['mse_z']:>10.2e}"
        f"{row['r2']:>9.5f}"
        for row in record["models"]
    ]
    tail = (
        f"{record['trainings']} trainings in {record['cpu_seconds']:.1f} s of one core; 20 units are"
        f" {record['range_EI_by_L']:.3g} E I/L; order {record['order']} (published"
        f" {record['published_order']}); certificate: {record['certificate']}"
    )
    _show({"schema": 1, **record}, "\n".join([head, *rows, tail]), json)


def _show(record: dict[str, Any], text: str, json: bool) -> None:
    """One JSON object on standard output, or text for people on standard error."""
    if json:
        from ancf.io import result_text

        print(result_text(record))
    else:
        print(text, file=sys.stderr)


def compare(
    directory: Data,
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Folder; DIR/compare.")] = None,
    seeds: Annotated[int, typer.Option("--seeds", min=1, help="Trainings of each network.")] = 5,
    epochs: Annotated[int | None, typer.Option("--epochs", min=1, help="Shorter trainings.")] = None,
    allow_unvalidated: Allow = False,
    json: Json = False,
) -> None:
    """Compare closed form, polynomial, radial basis functions, perceptrons, the paper's CNN, the best.

    On test rows, an independent design, a slab left out, the reference trajectory, disturbed poses and
    moments beyond the box; error radius, reachability, and solves that each saves. Writes compare.json and
    compare.md.

    Exit code 0: done. 2: the input is wrong. 4: the certificate of the data is not the valid one.
    """
    from ancf.io import result_text
    from surrogate.compare import compare as measure
    from surrogate.compare_text import compare_text
    from surrogate.evaluate import LeakWarning
    from surrogate.whole_file import write_text, writing

    problem = problem_of_folder(directory, allow_unvalidated)
    with writing(out or directory / "compare") as folder:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LeakWarning)  # it stands in the report
            record = measure(problem, range(seeds), epochs)
        text = compare_text(record)
        write_text(folder / "compare.json", result_text(record) + "\n")
        write_text(folder / "compare.md", text)
    _show(record, text, json)
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
    from surrogate.reproduce import report, reproduce as regenerate
    from surrogate.whole_file import write_text, writing

    problem = problem_of_folder(directory, allow_unvalidated)
    with writing(out or directory / "paper") as folder:
        record = regenerate(problem, folder)
        text = report(record)
        write_text(folder / "reproduction.json", result_text(record) + "\n")
        write_text(folder / "reproduction.md", text)
    _show(record, text, json)
    print(f"written: {folder}", file=sys.stderr)


def study(
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Folder; `ancf report` looks into report/surrogate.")
    ] = Path("report/surrogate"),
    seeds: Annotated[int, typer.Option("--seeds", min=1, help="Trainings of each network.")] = 5,
    epochs: Annotated[int | None, typer.Option("--epochs", min=1, help="Shorter trainings.")] = None,
    count: Annotated[int | None, typer.Option("--count", min=64, help="Rows of the Sobol design.")] = None,
    allow_unvalidated: Allow = False,
    json: Json = False,
) -> None:
    """Measure everything that the chapter "The surrogate" of `ancf report` shows; takes some minutes.

    Makes the data of both presets, runs `compare` and `reproduce` on them. Writes study.json and fig4.png ..
    fig11.png. JSON: study.json.

    Exit code 0: done. 2: the input is wrong. 4: no valid certificate.
    """
    from ancf.io import check_folder, result_text
    from surrogate.evaluate import LeakWarning
    from surrogate.study import RECORD, study as measure
    from surrogate.whole_file import write_text, writing
    from validation.certificate import NotValidated

    try:
        with writing(check_folder(out)) as folder, warnings.catch_warnings():
            warnings.simplefilter("ignore", LeakWarning)  # it stands in the record
            record = measure(
                folder, range(seeds), epochs, count=count, allow_unvalidated=allow_unvalidated, told=_tell
            )
            write_text(folder / RECORD, result_text(record) + "\n")
    except NotValidated as error:
        print(error.message, file=sys.stderr)
        raise typer.Exit(NOT_VALIDATED) from None
    verdicts = {True: "met", False: "NOT MET", None: ""}
    rows = record["asked"]
    lines = [f"{r['what']}: asked {r['asked']}; found {r['found']}  {verdicts[r['met']]}" for r in rows]
    _show(record, "\n".join(lines), json)
    print(f"written: {folder}", file=sys.stderr)


def _tell(text: str) -> None:
    print(text, file=sys.stderr)
