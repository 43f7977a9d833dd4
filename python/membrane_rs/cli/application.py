"""The application that holds the commands, and the reports of their errors."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer

app = typer.Typer(
    name="membrane-rs",
    help="Simulate the folding, spinning and deployment of thin membranes.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    typer.secho(f"Warning: {message}", fg="yellow", err=True)


FAILED, USAGE, INTERRUPTED = 1, 2, 130


def exit_code(stop: KeyboardInterrupt) -> int:
    """128 and the number of the signal, as a shell has it: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP."""
    return 128 + int(getattr(stop, "signum", INTERRUPTED - 128))


@contextmanager
def reported_errors() -> Iterator[None]:
    """Report an error of membrane_rs in one red line; other exceptions keep their traceback."""
    from membrane_rs.errors import InputError, MembraneError, MissingFileError
    from membrane_rs.runs import signals

    try:
        with signals.interruptible(), warnings.catch_warnings():
            warnings.filterwarnings("default", ".* is deprecated and is removed in version ", DeprecationWarning)
            warnings.showwarning = _show_warning
            yield
    except MembraneError as error:
        typer.secho(f"Error: {' '.join(str(error).split())}", fg="red", err=True)
        raise typer.Exit(USAGE if isinstance(error, (InputError, MissingFileError)) else FAILED) from None
    except KeyboardInterrupt as stop:
        typer.echo("Stopped; nothing was written.", err=True)
        raise typer.Exit(exit_code(stop)) from None
