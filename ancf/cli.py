"""The command `ancf`: finds its subcommands, turns every refusal into a message and an exit code.

Subcommands are entry points of the group ``ancf.commands`` and are imported only when called, so that
``ancf --help`` is quick and this package imports none of the others.
"""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from importlib.metadata import EntryPoint, entry_points
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from ancf.errors import InputError, Message

# Exit codes of the interface.
DONE, INPUT_WRONG, NO_EQUILIBRIUM = 0, 2, 3
PIPE_CLOSED = 141  # 128 + SIGPIPE, as a shell has it
INTERRUPTED = 130  # as shells report Ctrl-C

# One line each for the help, in the order of the help; the commands themselves are not imported for it.
DESCRIPTIONS = {
    "solve": "Solve a scene: static equilibrium, tip pose, section forces.",
    "check": "Check a scene and list what would be simulated.",
    "validate": "Run the validation and write report.json.",
    "report": "Run the validation and write report.html beside report.json.",
    "cost": "Show what accuracy costs in time, for problem families or for one scene.",
    "dataset": "Make an inverse-statics data set: loads and the tip poses they cause.",
    "train": "Train an inverse model on a data set: tip pose to tip moment.",
    "crossval": "Regenerate the paper's five-fold table.",
    "track": "Follow the paper's reference trajectory with a model, through the solver.",
    "compare": "Compare all inverse models, honestly, over several seeds.",
    "reproduce": "Regenerate figures 4 to 11 and table 1 of the paper.",
    "study": "Measure the surrogate: numbers and figures for the report.",
    "invert": "Find the tip moments for wanted tip poses.",
}

# Third-party package -> extra of this project that brings it.
EXTRAS = {
    "skfem": "reference",
    "meshio": "pictures",
    "matplotlib": "pictures",
    "pyvista": "pictures",
    "jinja2": "report",
    "torch": "surrogate",
    "onnx": "surrogate",
    "distributed": "cluster",
    "pyarrow": "parquet",
}


class CommandGroup(TyperGroup):
    """Subcommands from entry points: one line in the help, imported when called."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all installed subcommands, known ones first."""
        found = _installed()
        return [n for n in DESCRIPTIONS if n in found] + sorted(n for n in found if n not in DESCRIPTIONS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a stand-in that carries the line for the help."""
        if cmd_name not in _installed():
            return None
        return TyperCommand(name=cmd_name, help=DESCRIPTIONS.get(cmd_name, "An added command."))

    def resolve_command(self, ctx: Any, args: list[str]) -> tuple[str, Any, list[str]]:
        """Import and return the called subcommand; refuse one that does not exist."""
        name, found = args[0], _installed()
        if name in found:
            return name, _load(found[name]), args[1:]
        known = ", ".join(self.list_commands(ctx))
        from ancf.scene_table import nearest

        close = nearest(name, list(found))
        raise InputError(
            Message(
                f'Unknown command "{name}".',
                f"command line: ancf {name}",
                f'"{name}" is none of {known}',
                "a misspelt command" if close else "the package that brings it may not be installed",
                f'did you mean "{close}"?' if close else "see ancf --help",
            )
        )


app = typer.Typer(
    cls=CommandGroup,
    add_completion=False,
    rich_markup_mode=None,  # plain help: rich alone would take half of the time that --help may take
    pretty_exceptions_enable=False,
    invoke_without_command=True,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        import ancf

        print(f"ancf {ancf.__version__}")
        raise typer.Exit


@app.callback(
    epilog="Exit codes: 0 done, 2 the input is wrong, 3 no equilibrium found, 4 no valid certificate,"
    " 5 a required validation check failed."
)
def root(
    ctx: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Find the static equilibrium of soft continuum robots (ANCF beams)."""
    if ctx.invoked_subcommand is None:
        print(ctx.get_help())


def main(args: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; refusals are messages on standard error.

    Parameters
    ----------
    args : arguments without the program's name; None takes those of the process
    """
    arguments = list(sys.argv[1:] if args is None else args)
    said = io.StringIO()  # written at the end, and here: a stream that fails is then no fault of a command
    with redirect_stdout(said):
        code = _run(arguments)
    return _write(said.getvalue()) or code


def _run(arguments: list[str]) -> int:
    """Run a command and return its exit code; refusals are messages on standard error."""
    try:
        code = typer.main.get_command(app).main(args=arguments, prog_name="ancf", standalone_mode=False)
    except SystemExit:  # how typer and rich leave when the reader of standard error has gone
        return PIPE_CLOSED
    except InputError as error:
        return _refused(error.message)
    except ModuleNotFoundError as error:
        return _missing_package(error)
    except (typer.Abort, KeyboardInterrupt):
        return INTERRUPTED
    except Exception as error:
        # Typer keeps its usage errors in a private copy of click since 0.26: know them by their shape.
        if not (hasattr(error, "format_message") and hasattr(error, "exit_code")):
            raise
        return _refused(_usage_message(error, arguments))
    return code if isinstance(code, int) and not isinstance(code, bool) else DONE


def _write(text: str) -> int:
    """Write to standard output; 0, or the exit code where that fails."""
    if not text:
        return DONE
    try:
        if sys.stdout is None:
            raise OSError("it is closed")
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        if sys.stdout is not None:  # what is left in its buffer would fail once more when Python ends
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            return PIPE_CLOSED  # the reader, `head` say, has gone; nothing more can or need be said to it
        return _refused(
            Message(
                "The standard output cannot be written.",
                "standard output",
                str(error),
                "a full disk, or a stream that the caller has closed",
                "send it to a place with room, or write files with --out",
            )
        )
    return DONE


def _installed() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group="ancf.commands")}


def _load(point: EntryPoint) -> Any:
    """Import a subcommand, a plain function with typer's annotations or a typer application."""
    loaded = point.load()
    if isinstance(loaded, typer.Typer):
        return typer.main.get_command(loaded)
    single = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    single.command(name=point.name)(loaded)
    return typer.main.get_command(single)


def _refused(message: Message) -> int:
    print(message, file=sys.stderr)
    return INPUT_WRONG


def _usage_message(error: Any, arguments: list[str]) -> Message:
    """Return typer's usage error (unknown option, missing argument) in five parts."""
    context = getattr(error, "ctx", None)
    command = context.command_path if context is not None else "ancf"
    return Message(
        error.format_message(),
        f"command line: {command}",
        " ".join(["ancf", *arguments]),
        "an option or argument is misspelt, missing or of the wrong kind",
        f"see {command} --help",
    )


def _missing_package(error: ModuleNotFoundError) -> int:
    """Name the extra that brings a missing package; a missing module of our own is a bug."""
    package = (error.name or "").split(".")[0]
    if package not in EXTRAS:
        raise error
    return _refused(
        Message(
            f'This needs the package "{package}", which is not installed.',
            "command line",
            f'"{package}" belongs to the extra "{EXTRAS[package]}"',
            "the plain installation brings only what ancf solve needs",
            f"pip install 'ancf[{EXTRAS[package]}]'",
        )
    )


if __name__ == "__main__":
    sys.exit(main())
