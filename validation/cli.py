"""`ancf validate` and `ancf report`. Light at import: everything heavy is loaded when a command runs."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from validation.runner import Run

# Exit codes of interface.md; the last is the shell's for a program ended by Ctrl-C.
WRONG_INPUT, NOT_CERTIFIED, FAILED, INTERRUPTED = 2, 4, 5, 130

Quick = Annotated[bool, typer.Option("--quick", help="The quick set (default), about a minute.")]
Full = Annotated[bool, typer.Option("--full", help="All cases, finer meshes, more random examples.")]
Fresh = Annotated[
    bool,
    typer.Option("--fresh", help="Recompute stored references; do not go on with an interrupted run."),
]
Ship = Annotated[
    bool,
    typer.Option("--ship", help="With --full: also replace validation/certificate.json, which is shipped."),
]
Out = Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for report.json and report.html.")]
Only = Annotated[
    list[str] | None,
    typer.Option("--case", metavar="ID", help="Run this case only; may be repeated. Not a whole run."),
]


def validate(
    quick: Quick = False,
    full: Full = False,
    fresh: Fresh = False,
    out: Out = Path("report"),
    case: Only = None,
    ship: Ship = False,
) -> None:
    """Hold the solver against exact answers; writes report.json and, if all passed, certificate.json."""
    record, certificates = _run(quick, full, fresh, out, tuple(case or ()), ship)
    from validation.record import write_json

    _finish(record, [write_json(record, out), *certificates])


def report(
    quick: Quick = False,
    full: Full = False,
    fresh: Fresh = False,
    out: Out = Path("report"),
    ship: Ship = False,
    surrogate: Annotated[
        bool, typer.Option("--surrogate", help="Also run `ancf study` (some minutes) for its chapter.")
    ] = False,
) -> None:
    """Validate, then write one self-contained offline report.html beside report.json.

    The chapter on the surrogate shows the study in DIR/surrogate, if there is one.
    """
    record, certificates = _run(quick, full, fresh, out, (), ship)
    from validation.record import write_json
    from validation.report.page import write_page

    written = write_json(record, out)
    if surrogate:
        _study(out)
    started = time.perf_counter()
    page = write_page(record, out)
    sys.stderr.write(f"figures and page: {time.perf_counter() - started:.1f} s\n")
    _finish(record, [written, page, *certificates])


def _study(out: Path) -> None:
    """Measure the surrogate in a process of its own: nothing of it is imported here."""
    import subprocess

    from validation.report.surrogate_study import FOLDER

    command = [sys.executable, "-m", "ancf.cli", "study", "--out", str(out / FOLDER)]
    code = subprocess.run(command, stdout=subprocess.DEVNULL).returncode
    if code:
        sys.stderr.write(
            f"`ancf study` ended with exit code {code}; the chapter shows an older study or none\n"
        )


def _run(
    quick: bool, full: bool, fresh: bool, out: Path, wanted: tuple[str, ...], ship: bool
) -> tuple[Run, list[Path]]:
    """Check the input, run, certify; exits with code 2 and the five parts when the input is wrong."""
    pin_threads()
    from ancf.errors import InputError

    try:
        check_scope(quick, full)
        check_folder(out)
        _check_ship(full, wanted, ship)
        if wanted:
            _check_names(wanted)
        from validation.runner import all_cases

        all_cases()
        out.mkdir(parents=True, exist_ok=True)
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        raise typer.Exit(WRONG_INPUT) from None
    from validation.certify import certify
    from validation.runner import run

    try:
        with _Progress() as progress:
            record = run("full" if full else "quick", progress, wanted, folder=out, fresh=fresh)
    except KeyboardInterrupt:
        kept = f" What is finished is kept in {out}; the same command goes on from there." if full else ""
        sys.stderr.write(f"Interrupted.{kept}\n")
        raise typer.Exit(INTERRUPTED) from None
    return record, certify(record, out, ship)


def check_scope(quick: bool, full: bool) -> None:
    """Refuse both at once."""
    from ancf.errors import InputError, Message

    if quick and full:
        raise InputError(
            Message(
                "--quick and --full exclude each other.", "command line", "both were given",
                "a copied command", "keep one of them",
            )
        )  # fmt: skip


def check_folder(out: Path) -> None:
    """Refuse a folder that cannot be written, before anything is computed."""
    from ancf.errors import InputError, Message

    blocked = next((p for p in (out, *out.parents) if p.exists() and not p.is_dir()), None)
    if blocked is not None:
        raise InputError(
            Message(
                "The output folder is a file.", f"--out {out}", f"{blocked} exists and is no folder",
                "a file of that name was made before", "name another folder, or move the file away",
            )
        )  # fmt: skip
    existing = next(p for p in (out, *out.absolute().parents) if p.exists())
    if not os.access(existing, os.W_OK):
        raise InputError(
            Message(
                "The output folder cannot be written.", f"--out {out}", f"no permission in {existing}",
                "it belongs to somebody else", "name another folder",
            )
        )  # fmt: skip


def _check_ship(full: bool, wanted: tuple[str, ...], ship: bool) -> None:
    if not ship:
        return
    from ancf.errors import InputError, Message
    from validation.certificate import SHIPPED

    if not full or wanted:
        raise InputError(
            Message(
                "Only a whole full run can be shipped.", "--ship", "without --full, or with --case",
                "a quick or partial run gives no certificate", "add --full, leave out --case",
            )
        )  # fmt: skip
    if not os.access(SHIPPED.parent, os.W_OK):
        raise InputError(
            Message(
                "The shipped certificate cannot be written.", "--ship", f"no permission in {SHIPPED.parent}",
                "an installed package and not a checkout", "run it in a checkout of the project",
            )
        )  # fmt: skip


def _check_names(wanted: tuple[str, ...]) -> None:
    import difflib

    from ancf.errors import InputError, Message
    from validation.runner import all_cases

    known = [case.id for case in all_cases()]
    for name in wanted:
        if name not in known:
            near = difflib.get_close_matches(name, known, 1, 0.0)[0]
            raise InputError(
                Message(
                    f"There is no case {name!r}.", "--case", f"there are {len(known)}", "a misspelt name",
                    f"the nearest is {near!r}; report.json lists them all",
                )
            )  # fmt: skip


def pin_threads() -> None:
    """One thread for the linear algebra, unless the user chose or numpy is loaded already: "
    "timings then mean something."""
    if "numpy" not in sys.modules:
        for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
            os.environ.setdefault(name, "1")


class _Progress:
    """A progress bar on standard error when that is a terminal; silent otherwise."""

    def __enter__(self) -> _Progress:
        from rich.console import Console
        from rich.progress import Progress

        console = Console(stderr=True)
        self.bar = Progress(console=console, transient=True, disable=not console.is_terminal)
        self.tasks = {}
        self.bar.start()
        return self

    def __call__(self, part: str, done: int, count: int) -> None:
        if part not in self.tasks:
            self.tasks[part] = self.bar.add_task(part, total=count)
        self.bar.update(self.tasks[part], completed=done, total=count)

    def __exit__(self, *_: object) -> None:
        self.bar.stop()


def _finish(record: Run, written: list[Path]) -> None:
    """Print the outcome on standard error; exit code 5 when a required check failed or was inconclusive."""
    from rich.console import Console

    from validation.criteria import Verdict

    console = Console(stderr=True, highlight=False)
    verdict, reasons = record.verdict
    shown = "PARTIAL" if verdict is Verdict.PASS and not record.complete else str(verdict)
    counts = [r.verdict for r in record.cases]
    tally = ", ".join(f"{counts.count(v)} {v}" for v in Verdict if v in counts)
    if record.selection:
        for result in record.cases:
            for finding in result.findings:
                observed = "not finite" if finding.observed is None else f"{finding.observed:.4g}"
                console.print(
                    f"{result.case.id}: {finding.quantity}: {observed} {finding.limit.unit}, "
                    f"limit {finding.limit.value:g}: {finding.verdict}"
                )
    console.print(
        f"[bold]{shown}[/bold] ({record.scope}, {len(record.cases)} cases: {tally}; "
        f"{record.seconds['total']:.0f} s)"
    )
    for reason in reasons:
        console.print(f"  {reason}")
    for name in record.blocking:
        console.print(f"  failed: {name}")
    for notice in record.notices:
        console.print(f"  notice: {notice}", soft_wrap=True)
    for path in written:
        console.print(f"  written: {path}", soft_wrap=True)
    for line in _certificate_lines(record):
        console.print(f"  {line}", soft_wrap=True)
    if verdict is not Verdict.PASS:
        raise typer.Exit(FAILED)
    if record.scope == "full" and record.complete and record.certificate is None:
        raise typer.Exit(NOT_CERTIFIED)


def _certificate_lines(record: Run) -> list[str]:
    """What is to be said about the certificate: its id, or every reason against it up to five."""
    own = record.scope == "full" and record.complete
    whose = "this run" if own else "the shipped one, valid for this code"
    if record.certificate is not None:
        return [f"certificate: {record.certificate} ({whose})"]
    reasons = record.certificate_reasons
    more = [f"  and {len(reasons) - 5} more"] if len(reasons) > 5 else []
    none = "certificate: none" if own else "certificate: the shipped one does not hold for this code"
    return [none, *(f"  {reason}" for reason in reasons[:5]), *more]
