"""What the commands say beside their results, all on the standard error: remarks, warnings, errors.

`--verbose` adds to each error the Python lines that led to it, `--quiet` leaves out remarks and progress.
"""

from __future__ import annotations

import errno
import os
import shlex
import subprocess
import sys
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import typer

from membrane_rs.cli.usage import UsageError

FAILED, USAGE, INTERRUPTED = 1, 2, 130
"""Exit codes: the run failed; wrong usage or input; ended by Ctrl-C."""
TRACEBACK = "MEMBRANE_RS_TRACEBACK"
"""The environment variable that does what `--verbose` does."""


NARROWEST = 50
"""Letters in a line of help."""


@dataclass
class Verbosity:
    """How much a command says."""

    verbose: bool = False
    quiet: bool = False


verbosity = Verbosity()
"""Of the command that runs: there is one in a process."""


@dataclass
class Outcome:
    """What a script that asks for JSON is given of a command: its result, or the error that it ended with."""

    is_json: bool = False
    is_printed: bool = False
    error: str = ""

    def begin(self, *, is_json: bool) -> None:
        """Forget an earlier command of this process."""
        self.is_json, self.is_printed, self.error = is_json, False, ""


outcome = Outcome()
"""Of the command that runs."""


def tell(words: str) -> None:
    """A remark on the standard error, apart from the results; nothing with `--quiet`."""
    if not verbosity.quiet:
        typer.echo(words, err=True)


def nothing(words: str) -> None:
    """In place of `typer.echo`, where the result is a JSON document."""


def in_shell(path: os.PathLike[str]) -> str:
    """A path as a word of a command line, which neither a space nor a hyphen at its beginning changes."""
    word = os.fspath(path)
    word = os.path.join(os.curdir, word) if word.startswith("-") else word  # noqa: PTH118 - which Path takes away
    return subprocess.list2cmdline([word]) if os.name == "nt" else shlex.quote(word)


def exit_code(stop: KeyboardInterrupt) -> int:
    """128 and the number of the signal, as a shell has it: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP."""
    return 128 + int(getattr(stop, "signum", INTERRUPTED - 128))


@contextmanager
def reported_errors() -> Iterator[None]:
    """Report an error of membrane_rs in one red line, and any other one as a fault of the program."""
    from membrane_rs._extras import explained
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
        _show_traceback(error)
        show_error(str(error))
        raise typer.Exit(USAGE if isinstance(error, (InputError, MissingFileError)) else FAILED) from None
    except KeyboardInterrupt as stop:
        typer.echo("Stopped.", err=True)
        outcome.error = str(stop) or "ended by SIGINT"
        raise typer.Exit(exit_code(stop)) from None
    except Exception as error:
        if isinstance(error, typer.Exit | typer.Abort | UsageError) or (
            isinstance(error, OSError) and error.filename is None
        ):
            raise  # the last: of the standard output, which the program reports where it ends
        _show_traceback(error)
        if isinstance(error, OSError):  # the system refuses a path that was given
            show_error(f"{error.filename}: {error.strerror}; give another path")
            raise typer.Exit(USAGE) from None
        known = explained(error) if isinstance(error, ImportError) else error
        if known is not error:
            show_error(str(known))
            raise typer.Exit(FAILED) from None
        what = f"unexpected {type(error).__name__}: {error}. This is a fault of membrane_rs"
        show_error(f"{what}; please report it with the scene, and with what --verbose shows")
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


def show_error(words: str) -> None:
    """An error in one red line."""
    outcome.error = " ".join(words.split())
    say_in("red", f"Error: {outcome.error}")


def say_in(color: str, words: str) -> None:
    """Text on the standard error in a colour, where the terminal has some and nobody has asked for none."""
    plain = bool(os.environ.get("NO_COLOR")) or os.environ.get("TERM") == "dumb"
    typer.secho(words, fg=color, err=True, color=False if plain else None)


def print_anything() -> None:
    """Let names of files that are no text, or that the terminal's encoding lacks, be shown by escapes."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def widen() -> None:
    """Lay help out for a width in which it can be read, where the environment says that there is less."""
    columns = os.environ.get("COLUMNS", "")
    if columns.isdigit() and int(columns[:9]) < NARROWEST:
        os.environ["COLUMNS"] = str(NARROWEST)


def report_output(error: OSError) -> None:
    """Report that the standard output cannot be written, and write to it no more.

    Raises the error where it is another one, or that of a reader that has seen enough (`| head`).
    """
    if error.filename is not None or error.errno == errno.EPIPE:
        raise error
    # What waits in the stream's buffer would fail once more when Python ends.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    show_error(f"cannot write to the standard output: {error.strerror}")


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    say_in("yellow", f"Warning: {message}")


def _show_traceback(error: Exception) -> None:
    """The lines of Python that led to an error, where they are asked for."""
    if verbosity.verbose or os.environ.get(TRACEBACK):
        traceback.print_exception(error)
