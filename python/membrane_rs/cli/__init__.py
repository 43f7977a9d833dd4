"""The command line: translates options into calls of the package, and nothing else.

Exit codes: 0 success; 1 the run failed, or `check` found errors; 2 wrong usage or an invalid scene file; 128 and the
number of the signal where one ended it: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP. Heavy imports stand inside the
commands, so that `--help` is quick.
"""

from __future__ import annotations

# A command is registered by the import of its file: one line each.
from membrane_rs.cli import calibrate as calibrate
from membrane_rs.cli import compare as compare
from membrane_rs.cli import convert as convert
from membrane_rs.cli import export as export
from membrane_rs.cli import figures as figures
from membrane_rs.cli import fold as fold
from membrane_rs.cli import new as new
from membrane_rs.cli import report as report
from membrane_rs.cli import runs as runs
from membrane_rs.cli import scenes as scenes
from membrane_rs.cli import studies as studies
from membrane_rs.cli import sweep as sweep
from membrane_rs.cli import view as view
from membrane_rs.cli.application import FAILED, app, exit_code, print_anything, report_output, widen

__all__ = ["app", "main"]


def main() -> None:
    """Entry point of the command `membrane-rs`."""
    print_anything()
    widen()
    try:
        app()
    except KeyboardInterrupt as stop:
        raise SystemExit(exit_code(stop)) from None
    except OSError as error:
        report_output(error)
        raise SystemExit(FAILED) from None
