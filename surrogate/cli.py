"""`ancf dataset`. Light at import: everything heavy is loaded when the command runs."""

from __future__ import annotations

import os
import sys
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from surrogate.cli_data import NOT_VALIDATED

if TYPE_CHECKING:
    from collections.abc import Callable

    from surrogate.design import Design


def dataset(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for data.npz and card.json.")],
    design: Annotated[
        Path | None, typer.Argument(metavar="[DESIGN.toml]", help="A scene file with a table [design].")
    ] = None,
    preset: Annotated[
        str | None, typer.Option(metavar="paper|sobol", help="One of our own designs; default sobol.")
    ] = None,
    count: Annotated[int | None, typer.Option(help="Number of samples in place of the design's.")] = None,
    seed: Annotated[int | None, typer.Option(help="Seed in place of the design's.")] = None,
    workers: Annotated[int, typer.Option(min=1, help="Processes; the data do not depend on them.")] = 1,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Of a Dask scheduler, tcp://host:8786.")
    ] = None,
    shard: Annotated[
        str | None, typer.Option(metavar="i/n", help="Solve the i-th of n parts only, to be merged later.")
    ] = None,
    merge: Annotated[
        list[Path] | None,
        typer.Option(metavar="DIR", help="Put the shards in these folders together; may be repeated."),
    ] = None,
    parquet: Annotated[bool, typer.Option("--parquet", help="Write data.parquet too.")] = False,
    allow_unvalidated: Annotated[
        bool,
        typer.Option("--allow-unvalidated", help="Where no certificate vouches: stamp the data UNVALIDATED."),
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Make an inverse-statics data set: loads, and the tip poses that they cause.

    A run that was cut off goes on where it stopped when it is called again. The data are the same, byte for
    byte, whatever the number of workers and shards. JSON: the data card, and `folder`; of a shard `blocks`.

    Exit code 0: done. 2: the input is wrong, or the disk or a worker failed (what is finished is kept).
    4: no valid certificate, or samples outside its domain of validity.
    """
    # One thread for the linear algebra, unless the user chose: its matrices are small, and workers are many.
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    from validation.certificate import NotValidated

    _check_options(design, preset, workers, scheduler, shard, merge)
    if parquet:
        import_module("pyarrow")  # where it is missing, that is said before anything is solved
    try:
        with _Progress(json) as progress:
            if merge:
                answer = _merged(merge, out, allow_unvalidated)
            else:
                wanted = _design(design, preset, count, seed)
                answer = _solved(wanted, out, workers, scheduler, shard, allow_unvalidated, progress)
    except NotValidated as error:
        sys.stderr.write(f"{error.message}\n")
        raise typer.Exit(NOT_VALIDATED) from None
    except KeyboardInterrupt:
        sys.stderr.write(
            f"Interrupted. What is finished is kept in {out}; the same command goes on from there.\n"
        )
        raise
    if parquet and shard is None:
        _write_parquet(out)
    if json:
        from ancf.io import result_text

        print(result_text(answer))


def _solved(
    design: Design,
    out: Path,
    workers: int,
    scheduler: str | None,
    part: str | None,
    allow_unvalidated: bool,
    progress: Callable[[int, int], None],
) -> dict[str, Any]:
    """Solve a design, or one shard of it."""
    from ancf.io import check_folder
    from surrogate.executors import opened
    from surrogate.gate import ask
    from surrogate.plan import Plan
    from surrogate.sweep import assemble, finished, shard, sweep

    folder = check_folder(out)
    plan = Plan(design, ask(allow_unvalidated))
    blocks = range(plan.blocks) if part is None else shard(part, plan.blocks)
    whole = finished(plan, folder, allow_unvalidated)
    if not whole:
        with opened(workers, scheduler) as executor:
            sweep(plan, folder, blocks, executor, allow_unvalidated, progress)
    if part is not None:
        sys.stderr.write(f"{len(blocks)} of {plan.blocks} blocks, shard {part}: {folder}\n")
        return {"folder": str(folder), "shard": part, "blocks": list(blocks), "plan_id": plan.digest}
    if not whole:
        assemble(plan, folder, allow_unvalidated)
    return _told(folder)


def _merged(parts: list[Path], out: Path, allow_unvalidated: bool) -> dict[str, Any]:
    from ancf.io import check_folder
    from surrogate.sweep import merge

    merge(parts, check_folder(out), allow_unvalidated)
    return _told(out)


def _told(folder: Path) -> dict[str, Any]:
    """Read the data set back, say what it is, return its card."""
    from surrogate.dataset import load

    card = load(folder).card
    statuses = ", ".join(f"{count} {status}" for status, count in card["rows_by_status"].items())
    sys.stderr.write(f"{card['rows']} rows ({statuses}), certificate {card['certificate']}: {folder}\n")
    return {"folder": str(folder), **card}


def _design(path: Path | None, name: str | None, count: int | None, seed: int | None) -> Design:
    from ancf.scene_file import read_tables
    from surrogate.design import changed, preset

    if path is not None:
        return changed(read_tables(path), str(path), count, seed)
    return preset(name or "sobol", count, seed)


def _write_parquet(folder: Path) -> None:
    from surrogate.dataset import load
    from surrogate.parquet import TABLE, write
    from surrogate.whole_file import writing

    with writing(folder):
        write(load(folder), folder / TABLE)


def _check_options(
    design: Path | None,
    preset: str | None,
    workers: int,
    scheduler: str | None,
    shard: str | None,
    merge: list[Path] | None,
) -> None:
    """Refuse options that say two things."""
    if design is not None and preset is not None:
        _refuse(f"{design} --preset {preset}", "a design file and a preset are two designs")
    if scheduler is not None and workers > 1:
        _refuse(f"--scheduler {scheduler} --workers {workers}", "the scheduler has its own workers")
    if merge and (design is not None or preset is not None or shard is not None):
        _refuse("--merge with a design, a preset or --shard", "the shards know their design")


def _refuse(value: str, cause: str) -> NoReturn:
    from ancf.errors import InputError, Message

    raise InputError(
        Message("These options exclude each other.", "command line", value, cause, "keep one of them")
    )


class _Progress:
    """One line on standard error when that is a terminal and nobody asked for JSON; silent otherwise."""

    def __init__(self, quiet: bool) -> None:
        self.active = not quiet and sys.stderr.isatty()

    def __enter__(self) -> Callable[[int, int], None]:
        return self.show

    def show(self, done: int, count: int) -> None:
        if self.active:
            sys.stderr.write(f"\r\x1b[K{done}/{count} blocks")
            sys.stderr.flush()

    def __exit__(self, *_: object) -> None:
        if self.active:
            sys.stderr.write("\r\x1b[K")
