"""The application that holds the commands, and the reports of their errors."""

from __future__ import annotations

import errno
import os
import sys
import traceback
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

TRACEBACK = "MEMBRANE_RS_TRACEBACK"
"""The environment variable with which an unexpected error shows where it arose."""


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    typer.secho(f"Warning: {message}", fg="yellow", err=True)


FAILED, USAGE, INTERRUPTED = 1, 2, 130


def exit_code(stop: KeyboardInterrupt) -> int:
    """128 and the number of the signal, as a shell has it: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP."""
    return 128 + int(getattr(stop, "signum", INTERRUPTED - 128))


@contextmanager
def reported_errors() -> Iterator[None]:
    """Report an error of membrane_rs in one red line, and any other one as a fault of the program."""
    from membrane_rs.errors import AuditWarning, InputError, MembraneError, MissingFileError
    from membrane_rs.runs import signals

    print_anything()
    try:
        with signals.interruptible(), warnings.catch_warnings():
            warnings.filterwarnings("default", ".* is deprecated and is removed in version ", DeprecationWarning)
            warnings.simplefilter("ignore", AuditWarning)  # the commands report the audit themselves
            warnings.showwarning = _show_warning
            yield
    except MembraneError as error:
        typer.secho(f"Error: {' '.join(str(error).split())}", fg="red", err=True)
        raise typer.Exit(USAGE if isinstance(error, (InputError, MissingFileError)) else FAILED) from None
    except KeyboardInterrupt as stop:
        typer.echo("Stopped; nothing was written.", err=True)
        raise typer.Exit(exit_code(stop)) from None
    except Exception as error:
        if isinstance(error, typer.Exit | typer.Abort | typer.BadParameter | OSError):
            raise
        _report(error)
        raise typer.Exit(FAILED) from None


@contextmanager
def warnings_of_run() -> Iterator[None]:
    """Report what a run warns of when it is over: what its stages begin with, and what its bodies did."""
    from membrane_rs.errors import AuditWarning

    caught: list[warnings.WarningMessage] = []
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", AuditWarning)
            yield
    finally:
        for warning in caught:
            text = str(warning.message).removeprefix("warning: ")
            warnings.showwarning(text, warning.category, warning.filename, warning.lineno)


def print_anything() -> None:
    """Let names of files that are no text, or that the terminal's encoding lacks, be shown by escapes."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def report_output(error: OSError) -> None:
    """Report that the standard output cannot be written, and write to it no more.

    Raises the error where it is another one, or that of a reader that has seen enough (`| head`).
    """
    if error.filename is not None or error.errno == errno.EPIPE:
        raise error
    # What waits in the stream's buffer would fail once more when Python ends.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    typer.secho(f"Error: cannot write to the standard output: {error.strerror}", fg="red", err=True)


def _report(error: Exception) -> None:
    """Ask to report a fault of this program."""
    if os.environ.get(TRACEBACK):
        traceback.print_exception(error)
    text = f"Error: unexpected {type(error).__name__}: {' '.join(str(error).split())}. This is a fault of membrane_rs"
    how = f"please report it with the scene; {TRACEBACK}=1 in the environment shows where it arose"
    typer.secho(f"{text}; {how}", fg="red", err=True)
