"""The subcommands `ancf solve` and `ancf check`.

Standard output carries the JSON object of ``--json`` and nothing else; people read standard error.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ancf.cli import NO_EQUILIBRIUM
from ancf.errors import InputError, Message

if TYPE_CHECKING:
    from rich.console import Console

    from ancf.accuracy_record import Accuracy
    from ancf.model import Model
    from ancf.scene import Rod, Scene
    from ancf.segments import Segment
    from ancf.solution import Solution

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")]


def solve(
    scenes: Annotated[list[Path], typer.Argument(metavar="SCENE.toml", help="One or more scene files.")],
    json: Json = False,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Folder for result.json, .csv, .vtu and state.npz; a subfolder each for several scenes."
        ),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Picture (.png, .svg, .pdf), one panel for each scene.")
    ] = None,
    view: Annotated[
        Path | None, typer.Option(help="Interactive page (.html) of one scene, which needs no network.")
    ] = None,
) -> None:
    """Find the static equilibrium of one or more scenes.

    Exit code 0: converged. 2: the input is wrong, nothing was computed. 3: no equilibrium was found; the last
    one on the way and the reason are in the result.
    """
    from ancf import view as pictures, view_page
    from ancf.io import result_text, write_result
    from ancf.scene_file import load_scene
    from ancf.solver import prepare, solve as find_equilibrium

    loaded = [load_scene(path) for path in scenes]
    for scene in loaded:  # what can be refused is refused before anything is solved or written
        prepare(scene)
    if plot is not None:
        pictures.check_picture_path(plot)
    if view is not None:
        _check_one(scenes, view)
        view_page.check_page_path(view)
    folders = _folders(scenes, out)
    console = _console()
    solutions, results = [], []
    for path, scene, folder in zip(scenes, loaded, folders, strict=True):
        with _progress(console, f"solving {path}", quiet=json):
            solution = find_equilibrium(scene)
        solutions.append(solution)
        with _writing(folder):
            results.append(solution.as_dict() if folder is None else write_result(folder, solution))
        _report(console, path, solution, results[-1], brief=json)
    if plot is not None:
        with _progress(console, f"drawing {plot}", quiet=json), _writing(plot):
            pictures.draw(solutions, plot)
    if view is not None:
        with _progress(console, f"drawing {view}", quiet=json), _writing(view):
            view_page.write_page(solutions[0], view)
    if json:
        print(result_text(results[0] if len(results) == 1 else {"schema": 1, "results": results}))
    if any(result["status"] != "converged" for result in results):
        raise typer.Exit(NO_EQUILIBRIUM)


def check(
    scene: Annotated[Path, typer.Argument(metavar="SCENE.toml", help="The scene file.")],
    json: Json = False,
) -> None:
    """Check a scene: rods, effects that will be simulated, unknowns, reductions; advise on what could be left
    out or is missing.
    """
    from ancf.advice import advise
    from ancf.advice_text import advice_lines
    from ancf.io import result_text
    from ancf.reductions import sentences
    from ancf.scene_file import load_scene
    from ancf.scene_text import record_text, rod_lines
    from ancf.solver import prepare
    from ancf.validity import scene_warnings

    loaded = load_scene(scene)
    model = prepare(loaded)
    found = {
        "schema": 1,
        "title": loaded.title,
        "rods": {rod.name: _describe(rod) for rod in loaded.rods},
        "effects": ["elastic", *_listed(loaded)],
        **_wanted(loaded, model),
        "unknowns": model.unknowns,
        "reductions": sentences(model),
        "warnings": scene_warnings(model),
    }
    with _progress(console := _console(), f"solving {scene} for advice", quiet=json):
        advice = advise(model.scene, loaded.solver.accuracy)
    found["advice"] = advice.as_dict()
    if json:
        print(result_text(found))
        return
    console.print(f"{scene}: {loaded.title}" if loaded.title else str(scene))
    for rod in loaded.rods:
        for line in rod_lines(rod):
            console.print(f"  {line}", soft_wrap=True)
    for name, records in _listed(loaded).items():
        for record in records:
            console.print(f"  {name}: {record_text(record)}", soft_wrap=True)
    console.print(f"  effects:    {', '.join(found['effects'])}")
    first = ""
    if "accuracy" in found:
        console.print(f"  accuracy:   {found['accuracy']['wanted']:g} of the length at the tip")
        first = f" on the first mesh, of {sum(found['accuracy']['first_mesh'].values())} elements"
    console.print(f"  unknowns:   {found['unknowns']}{first}")
    for sentence in found["reductions"] or ["none"]:
        console.print(f"  reduction:  {sentence}", soft_wrap=True)
    for warning in found["warnings"]:
        console.print(f"  warning:    {warning}", soft_wrap=True)
    for line in advice_lines(advice):
        console.print(f"  {line}", soft_wrap=True)


def _wanted(scene: Scene, model: Model) -> dict[str, Any]:
    """The accuracy that a scene asks for and the mesh that is tried first; empty where it asks for none."""
    if scene.solver.accuracy is None:
        return {}
    first = {rod.rod.name: rod.rod.elements for rod in model.rods}
    return {"accuracy": {"wanted": scene.solver.accuracy, "first_mesh": first}}


def _check_one(scenes: list[Path], view: Path) -> None:
    """Refuse a page of several scenes."""
    if len(scenes) > 1:
        raise InputError(
            Message(
                "A page shows one scene.",
                f"command line: --view {view}",
                f"{len(scenes)} scenes, must be 1",
                "--plot draws several, --view does not",
                "solve the scenes one by one, each with a page of its own",
            )
        )


def _folders(scenes: list[Path], out: Path | None) -> list[Path | None]:
    """Choose and check the output folders: `out` for one scene, subfolders by file name for several."""
    from ancf.io import check_folder

    if out is None:
        return [None] * len(scenes)
    if len(scenes) == 1:
        return [check_folder(out)]
    twice = [name for name, count in Counter(path.stem for path in scenes).items() if count > 1]
    if twice:
        raise InputError(
            Message(
                "Two scenes would write into one folder.",
                f"--out {out}",
                f'the file name "{twice[0]}" occurs more than once',
                "each of several scenes gets a subfolder named after its file",
                "rename a scene file, or solve the scenes one by one",
            )
        )
    return [check_folder(out / path.stem) for path in scenes]


@contextmanager
def _writing(target: Path | None) -> Iterator[None]:
    """Turn a failure of the file system into a message."""
    try:
        yield
    except OSError as error:
        raise InputError(
            Message(
                "The results cannot be written.",
                str(target),
                str(error),
                "a full disk, a missing permission, or a folder in the place of a file",
                "make room there, or name another destination",
            )
        ) from error


def _console() -> Console:
    from rich.console import Console

    return Console(stderr=True, markup=False, highlight=False)


def _progress(console: Console, text: str, quiet: bool) -> Any:
    """Return a context that shows a spinner on a terminal, and nothing elsewhere."""
    return nullcontext() if quiet or not console.is_terminal else console.status(text)


def _report(console: Console, path: Path, solution: Solution, result: dict[str, Any], brief: bool) -> None:
    """Tell a person how the solve ended; `brief` leaves only what went wrong."""
    if not brief:
        from rich.table import Table

        table = Table(
            "rod", "tip x [m]", "tip y [m]", "tip z [m]", "strain energy [J]", title=_heading(path, solution)
        )
        for name, rod in result["rods"].items():
            table.add_row(name, *(f"{v:.8g}" for v in rod["tip"]["position"]), f"{rod['strain_energy']:.6g}")
        console.print(table)
        console.print(
            f"{result['status']}: {result['iterations']} iterations in {result['steps']} steps,"
            f" residual {result['residual']:.2g}, {result['unknowns']} unknowns,"
            f" {result['seconds']['total']:.3f} s"
        )
        if solution.accuracy is not None:
            console.print(_accuracy_text(solution.accuracy))
        if "stability" in result:
            console.print(_stability_text(result["stability"]))
    for warning in result["warnings"]:
        print(f"warning: {path}: {warning}", file=sys.stderr)
    if solution.message is not None:
        print(f"{path}: {solution.message}", file=sys.stderr)


def _accuracy_text(accuracy: Accuracy) -> str:
    """What was wanted, what is estimated and what was chosen for it, in a line."""
    rods = ", ".join(f"{rod.name}: {rod.elements} x {rod.element}" for rod in accuracy.rods)
    known = "unknown" if accuracy.estimate is None else f"{accuracy.estimate:.2g}"
    model = "unknown" if accuracy.model_error is None else f"{accuracy.model_error:.2g}"
    rounds = len(accuracy.tried)
    return (
        f"accuracy {accuracy.wanted:g} {'met' if accuracy.met else 'not met'}: estimated tip error / length"
        f" {known} by the mesh, {model} by the sections; {rods}, chosen in {rounds} round{'s' * (rounds > 1)}"
    )


def _stability_text(stability: dict[str, Any]) -> str:
    """What is known of the stability, in a line."""
    count = stability["negative_pivots"]
    parts = ["stable" if count == 0 else f"unstable: {count} negative eigenvalue{'s' * (count > 1)}"]
    if "no potential" in stability["note"]:
        parts = [f"{count} negative eigenvalue{'s' * (count != 1)} known"]
    if stability["note"]:
        parts.append(stability["note"])
    met = [
        f"{point['kind']} at {point['load_factor']:.5g}"
        + (f" ({point['multiplicity']} modes)" if point["multiplicity"] > 1 else "")
        for point in stability["critical_points"]
    ]
    return "; ".join([*parts, *(["critical points by load factor: " + ", ".join(met)] if met else [])])


def _heading(path: Path, solution: Solution) -> str:
    return f"{solution.scene.title} ({path})" if solution.scene.title else str(path)


def _listed(scene: Scene) -> dict[str, Sequence[Any]]:
    """Records of effects and joints by the name of their table."""
    joints = {"joint": scene.joints} if scene.joints else {}
    return {**scene.listed, **joints}


def _describe(rod: Rod) -> dict[str, Any]:
    """Return what a rod is, in plain Python and SI units."""
    segments = [
        {"length": part.length, "elements": part.elements or None, **_made_of(part)} for part in rod.segments
    ]
    return {
        "length": rod.length,
        "elements": rod.elements or None,  # null: to be chosen
        "element": rod.element,
        "formulation": rod.formulation,
        "axial_rule": rod.axial_rule,
        "base": {
            "position": rod.base.position.tolist(),
            "x_axis": rod.base.rotation[:, 0].tolist(),
            "y_axis": rod.base.rotation[:, 1].tolist(),
        },
        "curvature": rod.curvature.tolist(),
        "shear_factors": list(rod.shear_factors),
        **({"segments": segments} if segments else _made_of(rod.parts[0])),
        "supports": [{"at": support.at, "kind": support.kind} for support in rod.supports],
    }


def _made_of(segment: Segment) -> dict[str, Any]:
    """Section and material of a segment as a scene file writes them."""
    from ancf.scene_materials import law_name

    sections = {
        "section": segment.section,
        **({"section_end": segment.section_end} if segment.tapered else {}),
    }
    shapes = {key: {"shape": type(one).__name__.lower(), **_fields(one)} for key, one in sections.items()}
    return {**shapes, "material": {"law": law_name(segment.material), **_fields(segment.material)}}


def _fields(record: Any) -> dict[str, Any]:
    """Fields of a frozen record that are set."""
    values = {field.name: getattr(record, field.name) for field in fields(record)}
    return {key: value for key, value in values.items() if value is not None}
