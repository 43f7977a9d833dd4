"""Arguments and options that several commands share, and their values."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from membrane_rs._renamed import deprecated

if TYPE_CHECKING:
    from membrane_rs.mesh.findings import Audit
    from membrane_rs.runs import Simulation
    from membrane_rs.scene import Scene

SUFFIXES = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0}


def number(text: str) -> float:
    """A number of the command line. Raises BadParameter, which names the value and what to write."""
    try:
        return float(text)
    except ValueError:
        raise typer.BadParameter(
            f"{text!r} is no number; write one in SI units without its unit{_plain(text)}"
        ) from None


def count(text: str) -> int:
    """A whole number of the command line. Raises BadParameter, which names the value."""
    try:
        return int(text)
    except ValueError:
        raise typer.BadParameter(f"{text!r} is no whole number; write one such as 10") from None


def _plain(text: str) -> str:
    """A time with its unit, in seconds, for the end of a message."""
    found = re.fullmatch(r"\s*([-+\d.eE]+)\s*([a-z]+)\s*", text)
    with suppress(ValueError):
        if found is not None and found[2] in SUFFIXES:
            return f", such as {float(found[1]) * SUFFIXES[found[2]]:.12g} (s)"
    return ""


def numeric_option(help: str) -> Any:  # noqa: A002 - typer's own word
    """An option that takes a number."""
    return typer.Option(help=help, parser=number, metavar="FLOAT")


def count_option(help: str) -> Any:  # noqa: A002 - typer's own word
    """An option that takes a whole number."""
    return typer.Option(help=help, parser=count, metavar="INTEGER")


SceneArgument = Annotated[str, typer.Argument(metavar="SCENE", help="A built-in scene, or the path of a TOML file.")]
Until = Annotated[float | None, numeric_option(help="Simulated time at the end [s]. Default: the scene's.")]
Integrator = Annotated[str | None, typer.Option(help="Name of the method. Default: the scene's.")]
Dt = Annotated[
    float | None, numeric_option(help="Step [s]. Default: from stability and slow motion; dopri5: by its error.")
]
Tolerance = Annotated[float | None, numeric_option(help="Tolerance for the error of dopri5. Default: the scene's.")]
SpectralRadius = Annotated[
    float | None,
    numeric_option(help="Amplification per step of modes that an implicit method cannot resolve: 0 to 1."),
]
Substeps = Annotated[
    int | None,
    count_option(help="Substeps of leapfrog in a step, for laws that are not slow. Default: the scene's."),
]
ShortSteps = Annotated[int | None, typer.Option("--short-steps", hidden=True, help="The old name of --substeps.")]
Out = Annotated[Path | None, typer.Option(help="Folder of the results. Default: runs/ and the scene's name.")]
Frames = Annotated[int | None, count_option(help="Number of shapes written, evenly spaced. Default: the scene's.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace an earlier run in the same folder.")]
Ensemble = Annotated[
    int | None, count_option(help="Number of runs from perturbed starts; 0: none. Default: depends on the study.")
]
Rows = Annotated[str, typer.Option(help="Mesh densities: rows of cells of a petal, separated by commas.")]
Jobs = Annotated[int | None, count_option(help="Number of parallel runs. Default: one on each core.")]
Checkpoint = Annotated[
    float, numeric_option(help="Seconds of wall time between two checkpoints, from which a killed run is resumed.")
]
NoPictures = Annotated[bool, typer.Option("--no-pictures", help="Draw no pictures at the end.")]


def load(scene: str) -> Scene:
    """A built-in scene by its name, or a scene file by its path (ending or slash)."""
    from membrane_rs import scenes as built_in
    from membrane_rs.scene import Scene

    if scene.endswith(".toml") or "/" in scene or Path(scene).is_file():
        return Scene.from_toml(scene)
    return built_in.load(scene)


def simulation_of(scene: Scene) -> Simulation:
    """The simulation of a scene; what its audit finds is reported first, also where the scene is refused."""
    from membrane_rs.errors import MembraneError
    from membrane_rs.runs import Simulation

    try:
        sim = Simulation(scene)
    except MembraneError:
        report_audit(scene)
        raise
    report(sim.audit())
    return sim


def report_audit(scene: Scene) -> None:
    """Report the errors and warnings of the audit of a scene on the standard error, costly checks left out."""
    from membrane_rs.check import audit

    report(audit(scene, costly=False))


def report(audit: Audit) -> None:
    """Report the errors and warnings of an audit on the standard error."""
    found = audit.without_facts()
    if found.findings:
        typer.secho(f"Audit: {found}", fg="yellow" if found.ok else "red", err=True)


def with_settings(scene: Scene, wanted: dict[str, Any]) -> Scene:
    """The scene with the run settings that were given on the command line."""
    from dataclasses import asdict, replace

    from membrane_rs._validation import build
    from membrane_rs.scene.run_settings import RunSettings

    given = {name: value for name, value in wanted.items() if value is not None}
    return replace(scene, run=build(RunSettings, asdict(scene.run) | given, "run")) if given else scene


def numbers(text: str, option: str) -> list[float]:
    """Numbers separated by commas. Raises InputError, which names the option."""
    from membrane_rs.errors import InputError

    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        raise InputError(f"{option} = {text!r}: must be numbers separated by commas") from None


def whole(number: float, option: str) -> int:
    """A whole number of at least 1. Raises InputError, which names the option."""
    from membrane_rs.errors import InputError

    if not number.is_integer() or number < 1:
        raise InputError(f"{option} = {number:g}: must be whole numbers from 1 on, separated by commas")
    return int(number)


def substeps_of(substeps: int | None, short_steps: int | None) -> int | None:
    """The value of --substeps, or of its old name --short-steps, with a warning."""
    if short_steps is not None:
        deprecated("--short-steps", "use --substeps")
    return short_steps if substeps is None else substeps
