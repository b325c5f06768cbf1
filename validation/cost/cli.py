"""`ancf cost`. Light at import: everything heavy is loaded when the command runs."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Annotated, Any

import typer

NO_EQUILIBRIUM = 3  # exit code of interface.md


def cost(
    scene: Annotated[
        Path | None, typer.Argument(metavar="[SCENE.toml]", help="A scene file; without it, all families.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Folder for cost.json and figures (SVG).")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Few meshes (default), some 20 s.")] = False,
    full: Annotated[bool, typer.Option("--full", help="All meshes and settings, some minutes.")] = False,
) -> None:
    """Show what accuracy costs in time: for the problem families, or for one scene.

    With a scene: which element and mesh its tip needs for 1 %, 0.1 % and 0.01 % of the length, by comparison
    with the limit of its own ladder of meshes. Without: tip errors against independent references.

    JSON, families: families[] = {name, problem, reference {name, kind, source, error, position, thickness},
    points[], floors[], omissions[], cheapest[], recommendation}, tangent_ratio[], scaling[].

    JSON, scene: needs[] = {target, reached, element, formulation, elements, error, seconds, by_element[]},
    ladders[] = {element, formulation, limit, error_bar, order, distance, points[]}, omissions[], warnings[],
    recommendation.

    points[] = {model, kind, formulation, elements, mesh, tangent, predictor, status, position, unknowns,
    iterations, steps, error, discretisation, seconds {fastest, median, repeats}, parts {setup, kinematics,
    assembly, effects, linear_solve, rest}}. Errors are by the length of the rod, times are CPU seconds of
    warm solves on one thread; what is not known is null.

    Exit code 0: done. 2: the input is wrong. 3: no mesh of the scene has an equilibrium.
    """
    from validation.cli import check_folder, check_scope, pin_threads

    pin_threads()
    from ancf.errors import InputError

    check_scope(quick, full)
    if out is not None:
        check_folder(out)
    scope = "full" if full else "quick"
    started = time.process_time()
    if scene is not None:
        record, show, figures, failed = _scene(scene, full, json)
    else:
        record, show, figures, failed = _families(full, json)
    record["seconds"] = time.process_time() - started
    record["scope"] = scope
    if out is not None:
        try:
            _write(out, record, figures)
        except OSError as error:
            from ancf.errors import Message

            raise InputError(
                Message(
                    "The results cannot be written.", str(out), str(error),
                    "a full disk or a missing permission",
                    "name another folder",
                )
            ) from error  # fmt: skip
    if json:
        from ancf.io import result_text

        print(result_text(record))
    else:
        from rich.console import Console

        show(Console(highlight=False, markup=False, width=None if sys.stdout.isatty() else 200))
    if failed:
        sys.stderr.write("No mesh of any element has an equilibrium; the reasons are among the omissions.\n")
        raise typer.Exit(NO_EQUILIBRIUM)


def _scene(path: Path, full: bool, quiet: bool) -> tuple[dict[str, Any], Any, Any, bool]:
    from validation.cost import scene_record
    from validation.cost.ladder import scene_cost

    with _Progress(quiet) as progress:
        found = scene_cost(path, full, progress)
    data = scene_record.scene_dict(found)

    def figures() -> dict[str, str]:
        from validation.report.figures_cost import scene_figure

        return {"scene": str(scene_figure(found))}

    return data, lambda console: scene_record.print_scene(found, data, console), figures, not found.converged


def _families(full: bool, quiet: bool) -> tuple[dict[str, Any], Any, Any, bool]:
    from validation.cost import record
    from validation.cost.run import measure_all
    from validation.cost.scaling import COUNTS, COUNTS_FULL, scale, tangent_ratios

    with _Progress(quiet) as progress:
        costs = measure_all(full, progress)
        scaling = scale(COUNTS_FULL if full else COUNTS)
    data = record.families_dict(costs, tangent_ratios(), scaling)

    def figures() -> dict[str, str]:
        from validation.report.figures_cost import family_figure
        from validation.report.matrix import slug

        return {slug(c.name): str(family_figure(c)) for c in costs}

    return data, lambda console: record.print_families(costs, data, console), figures, False


def _write(out: Path, record: dict[str, Any], figures: Any) -> None:
    """Write cost.json and, where matplotlib is installed, a log-log figure each."""
    from ancf.io import result_text
    from validation.record import write_text

    out.mkdir(parents=True, exist_ok=True)
    write_text(out / "cost.json", result_text(record) + "\n")
    try:
        from validation.report.style import styled

        with styled():
            drawn = figures()
    except ModuleNotFoundError as error:
        sys.stderr.write(f"no figures: {error.name} is not installed (pip install 'ancf[report]')\n")
        return
    for name, svg in drawn.items():
        write_text(out / f"cost-{name}.svg", svg)


class _Progress:
    """One line on standard error when that is a terminal and nobody asked for JSON; silent otherwise."""

    def __init__(self, quiet: bool) -> None:
        self.active = not quiet and sys.stderr.isatty()

    def __enter__(self) -> _Progress:
        return self

    def __call__(self, what: str, done: int, count: int) -> None:
        if self.active:
            sys.stderr.write(f"\r\x1b[K{done + 1}/{count} {what}")
            sys.stderr.flush()

    def __exit__(self, *_: object) -> None:
        if self.active:
            sys.stderr.write("\r\x1b[K")
