"""The application that holds the commands: their panels in the help, their common options, their results as JSON.

A command is a function with the decorator `command`, in a file of cli/ that `cli/__init__.py` imports. Its parameters
are its arguments and options, the first line of its docstring says what it does.
"""

from __future__ import annotations

import inspect
import json
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import copy
from functools import wraps
from typing import Annotated, Any, get_args, get_origin

import typer
from typer.core import TyperCommand, TyperGroup

from membrane_rs.cli.reporting import (
    FAILED,
    INTERRUPTED,
    TRACEBACK,
    USAGE,
    exit_code,
    in_shell,
    nothing,
    outcome,
    print_anything,
    report_output,
    reported_errors,
    say_in,
    show_error,
    tell,
    verbosity,
    warnings_of_run,
    widen,
)
from membrane_rs.cli.usage import UsageError, in_our_words, surplus, unknown_command

__all__ = [
    "FAILED",
    "INTERRUPTED",
    "LOOKING",
    "MANY_RUNS",
    "RUNS",
    "SCENES",
    "STUDIES",
    "TRACEBACK",
    "USAGE",
    "Json",
    "app",
    "command",
    "exit_code",
    "in_shell",
    "nothing",
    "print_anything",
    "print_json",
    "report_output",
    "reported_errors",
    "say_in",
    "show_error",
    "tell",
    "warnings_of_run",
    "widen",
]

SCENES, RUNS, LOOKING, MANY_RUNS, STUDIES = "Scenes", "Runs", "Looking", "Many runs", "Studies"
EXAMPLE_WIDTH = 66
"""Columns of a line of an example: with "Example: " before it and a backslash behind, a terminal has 80."""
PANELS = (SCENES, RUNS, LOOKING, MANY_RUNS, STUDIES)
"""Panels of `membrane-rs --help`, in their order."""
EXIT_CODES = (
    "Exit codes: 0 success; 1 the run failed, or check found errors; 2 wrong usage, or an invalid scene or file; "
    "128 and the number of the signal that ended it, such as 130 for Ctrl-C."
)

Json = Annotated[
    bool, typer.Option("--json", help="Print the result as one JSON document; all else goes to the standard error.")
]
_Verbose = Annotated[
    bool, typer.Option("--verbose", "-v", help="Show with an error the lines of Python that led to it.")
]
_Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="Neither progress nor remarks; warnings and errors remain.")
]


def _without_types_of_python(params: list[Any]) -> list[Any]:
    """Parameters whose help says neither `<bool>` beside a flag, as if it took a value, nor `<str>` beside a text."""
    for param in params:
        if param.param_type_name == "option" and param.metavar is None:
            param.metavar = "" if param.is_flag else "TEXT"  # numbers, paths and quantities have words of their own
    return params


@contextmanager
def _of(ctx: Any) -> Iterator[None]:
    """Give errors of usage the context, which some of click's lack."""
    try:
        yield
    except UsageError as error:
        error.ctx = error.ctx or ctx
        raise


class Command(TyperCommand):
    """One command."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Its arguments and options."""
        return _without_types_of_python(super().get_params(ctx))

    def parse_args(self, ctx: Any, args: list[str]) -> Any:
        """Take its words; an error knows the command, and a word too many is refused here."""
        ctx.allow_extra_args = True
        with _of(ctx):
            rest = super().parse_args(ctx, args)
        if ctx.args and not ctx.resilient_parsing:
            raise UsageError(surplus(ctx.args[0], ctx), ctx)
        return rest


class Commands(TyperGroup):
    """The commands in the order of their panels, and how the program ends."""

    def main(self, args: Any = None, *, standalone_mode: bool = True, **options: Any) -> Any:  # type: ignore[override]
        """Run a command, and end with its exit code; wrong usage is said in one line."""
        if not standalone_mode:
            return super().main(args, standalone_mode=False, **options)
        words = list(sys.argv[1:] if args is None else args)
        outcome.begin(is_json="--json" in words)
        try:
            code = super().main(args, standalone_mode=False, **options) or 0
        except UsageError as error:
            show_error(in_our_words(error))
            code = USAGE
        if code and outcome.is_json and not outcome.is_printed:
            print_json({"error": outcome.error, "exit_code": code})
        sys.exit(code)

    def parse_args(self, ctx: Any, args: list[str]) -> Any:
        """Take the words before a command; an error knows the program."""
        with _of(ctx):
            return super().parse_args(ctx, args)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that is called; where there is none of that name, the error names a near one, or all."""
        if self.get_command(ctx, args[0]) is None and not ctx.resilient_parsing:
            known = [name for name in self.list_commands(ctx) if not self.commands[name].hidden]
            raise UsageError(unknown_command(args[0], known), ctx)
        return super().resolve_command(ctx, args)

    def get_params(self, ctx: Any) -> list[Any]:
        """The options before a command."""
        return _without_types_of_python(super().get_params(ctx))

    def list_commands(self, ctx: Any) -> list[str]:
        """Their names."""
        panels = {name: getattr(each, "rich_help_panel", None) for name, each in self.commands.items()}
        return sorted(panels, key=lambda name: PANELS.index(panels[name]) if panels[name] in PANELS else len(PANELS))


def literal(words: str) -> str:
    """Text for typer's help, in which `[s]` would be taken for markup of rich."""
    return re.sub(r"\[(?=[a-zA-Z#/@])", r"\\[", words)


app = typer.Typer(
    name="membrane-rs",
    cls=Commands,
    help="Simulate the folding, spinning and deployment of thin membranes.",
    epilog=f"membrane-rs COMMAND --help shows the options of a command, and an example.\n\n{EXIT_CODES}",
    invoke_without_command=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)


def _show_versions(wanted: bool) -> None:
    """The versions of what takes part in the numbers, and the vector instructions of the core."""
    if wanted:
        from membrane_rs import Scene, Simulation, Tether
        from membrane_rs.results.run_summary import versions

        smallest = Simulation(Scene(None, None, parts=[Tether((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 1, 10.0, 1e-4)]))
        found = versions()
        typer.echo(f"membrane-rs {found.pop('membrane_rs')}")
        for name, version in {**found, "instructions": smallest.instructions}.items():
            typer.echo(f"{name} {version}")
        raise typer.Exit


@app.callback()
def _root(
    context: typer.Context,
    *,
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_versions, is_eager=True, help="Show versions and processor, and end."),
    ] = False,
    verbose: _Verbose = False,
    quiet: _Quiet = False,
) -> None:
    verbosity.verbose, verbosity.quiet = verbose, quiet
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(USAGE)


def command(
    panel: str, *, example: str, name: str | None = None, hidden: bool = False
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Make a function a command: its errors are reported, and it takes `--verbose` and `--quiet`.

    Parameters
    ----------
    panel :
        One of `PANELS`, under which the help lists it.
    example :
        What runs in an empty folder within seconds, without the program's name: "run spinning-tether --until 0.01";
        lines before the last prepare it.
    name :
        The command's name. Default: the function's, with hyphens.
    hidden :
        Whether the help leaves it out, as it does an old name.
    """

    def register(function: Callable[..., None]) -> Callable[..., None]:
        @wraps(function)
        def call(*, verbose: bool, quiet: bool, **options: Any) -> None:
            verbosity.verbose |= verbose
            verbosity.quiet |= quiet
            with reported_errors():
                function(**options)

        given = inspect.signature(function, eval_str=True)
        kinds = {key: each.annotation for key, each in given.parameters.items()} | {
            "verbose": _Verbose, "quiet": _Quiet
        }  # fmt: skip
        kinds = {key: _with_literal_help(kind) for key, kind in kinds.items()}
        common = [
            inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, default=False, annotation=kinds[key])
            for key in ("verbose", "quiet")
        ]
        own = [each.replace(annotation=kinds[key]) for key, each in given.parameters.items()]
        call.__signature__ = given.replace(parameters=[*own, *common])  # type: ignore[attr-defined]
        call.__annotations__ = kinds
        app.command(
            name,
            cls=Command,
            help=literal(_without_breaks(inspect.getdoc(function) or "")),
            epilog=literal("Example: " + "\n".join(_in_lines(f"membrane-rs {line}") for line in example.splitlines())),
            rich_help_panel=panel,
            hidden=hidden,
        )(call)
        return function

    return register


def _without_breaks(words: str) -> str:
    """Paragraphs of a docstring, each in one line, which the help wraps itself."""
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in words.split("\n\n"))


def _in_lines(example: str) -> str:
    """A command in lines that a terminal does not wrap, an option beside its value; a shell takes them for one."""
    lines: list[str] = []
    for word in re.findall(r"(?:-\S+ (?!-))?(?:\"[^\"]*\"|'[^']*'|\S)+", example):
        if lines and len(lines[-1]) + 1 + len(word) <= EXAMPLE_WIDTH:
            lines[-1] += f" {word}"
        else:
            lines.append(f"  {word}" if lines else word)
    return " \\\n".join(lines)


def _with_literal_help(kind: Any) -> Any:
    """An annotated type whose help is shown letter by letter."""
    if get_origin(kind) is not Annotated:
        return kind
    plain, *notes = get_args(kind)
    shown = []
    for note in map(copy, notes):
        if isinstance(getattr(note, "help", None), str):
            note.help = literal(note.help)
        shown.append(note)
    annotated: Any = Annotated
    both = (plain, *shown)
    return annotated[both]


def print_json(document: Any) -> None:
    """Print one JSON document on the standard output; NaN and infinities become null."""
    from membrane_rs.results.run_summary import plain

    outcome.is_printed = True
    typer.echo(json.dumps(plain(document), indent=2, allow_nan=False))
