"""The application that commands join, and how their errors are told."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import typer

app = typer.Typer(
    name="membrane-rs",
    help="Simulate the folding, spinning and deployment of thin membranes.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

FAILED, USAGE, INTERRUPTED = 1, 2, 130


@contextmanager
def told_errors() -> Iterator[None]:
    """One red line for what a user can mend; a traceback is for our own mistakes."""
    from membrane_rs.errors import InputError, MembraneError, MissingFileError

    try:
        yield
    except MembraneError as error:
        typer.secho(f"Error: {' '.join(str(error).split())}", fg="red", err=True)
        raise typer.Exit(USAGE if isinstance(error, (InputError, MissingFileError)) else FAILED) from None
    except KeyboardInterrupt:
        typer.echo("Stopped; nothing was written.", err=True)
        raise typer.Exit(INTERRUPTED) from None
