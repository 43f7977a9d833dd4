"""The command that fits parameters of a scene to measured curves."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from typing_extensions import Unpack

from membrane_rs.cli import completion
from membrane_rs.cli.application import MANY_RUNS, Json, command, print_json, tell
from membrane_rs.cli.many_runs import RunOptions, make_runs, takes_run_options
from membrane_rs.cli.options import SceneArgument, Set, count_option, load, numeric_option, words

Data = Annotated[
    Path,
    typer.Option(metavar="FILE", help='A CSV file: "time [s]" and columns of the history, such as "hub_torque [N m]".'),
]
Vary = Annotated[
    list[str] | None,
    typer.Option(
        "--vary",
        metavar="KEY=RANGE",
        autocompletion=completion.keys,
        help="A value of the scene and its range: laws.creases.stiffness=1:30:log, material.thickness=5um:10um. May "
        "be given several times.",
    ),
]
Uncertainty = Annotated[
    list[str] | None,
    typer.Option(
        metavar="COLUMN=VALUE",
        help="Standard deviation of each value of a column, such as hub_torque=2mN*m. Default: a column COLUMN_std, "
        "else unknown.",
    ),
]


@command(
    MANY_RUNS,
    example="""run spinning-tether --set laws.spin.frequency=2.5 --until 0.05 --no-pictures --out runs/other
calibrate spinning-tether --data runs/other/history.csv --columns hub_force --vary laws.spin.frequency=1:4""",
)
@takes_run_options
def calibrate(
    scene: SceneArgument,
    *,
    data: Data,
    vary: Vary = None,
    set_: Set = None,
    starts: Annotated[int, count_option(help="Runs of each set of values, whose mean is compared.")] = 1,
    method: Annotated[
        str, typer.Option(help="least-squares, or nelder-mead where curves are too rough for differences.")
    ] = "least-squares",
    columns: Annotated[
        str | None, typer.Option(metavar="NAMES", help="Columns of the data, separated by commas. Default: all.")
    ] = None,
    uncertainty: Uncertainty = None,
    step: Annotated[
        float | None, numeric_option(help="Step of differences, as a share of the ranges. Default: 0.02; 0.05.")
    ] = None,
    most_runs: Annotated[int, count_option(help="Runs at most; the best values so far are the result.")] = 500,
    json: Json = False,
    **options: Unpack[RunOptions],
) -> None:
    """Fit values of a scene to measured curves: values, errors, and what the data do not determine.

    Ctrl-C stops and keeps the runs that are done; the same command goes on with them.
    """
    from membrane_rs.errors import InputError
    from membrane_rs.study import calibrate as study
    from membrane_rs.study.common.vary import split_vary

    varied = split_vary(vary or [])
    if not varied:
        raise InputError("calibrate: nothing is varied; give --vary KEY=RANGE, such as laws.creases.stiffness=1:30:log")
    chosen = load(scene, set_)
    asked = partial(
        study, data=data, vary=varied, starts=starts, method=method, step=step, most_runs=most_runs,
        columns=None if columns is None else words(columns, "--columns"), uncertainty=_deviations(uncertainty or []),
    )  # fmt: skip
    found, folder = make_runs(asked, chosen, "calibration", options)
    say = tell if json else typer.echo
    say(f"{found.outcome} after {found.runs} runs: misfit {found.misfit:.4g}, at the start {found.first_misfit:.4g}\n")
    say(found.table())
    for path in found.save(folder, title=chosen.name):
        say(f"Wrote {path}")
    if json:
        print_json({"scene": chosen.name, "folder": str(folder), **found.as_dict()})


def _deviations(texts: list[str]) -> dict[str, float | str]:
    """Standard deviations by column. Raises InputError."""
    from membrane_rs.errors import InputError

    found: dict[str, float | str] = {}
    for text in texts:
        name, sign, value = (part.strip() for part in text.partition("="))
        if not sign or not name or not value:
            raise InputError(f"--uncertainty {text!r}: must be COLUMN=VALUE, such as hub_torque=2mN*m")
        if name in found:
            raise InputError(f"--uncertainty {name}: is given twice; give it once")
        try:
            found[name] = float(value)
        except ValueError:
            found[name] = value
    return found
