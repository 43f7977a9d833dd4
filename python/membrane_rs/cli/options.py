"""Arguments and options that several commands share, and their values."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from membrane_rs._renamed import deprecated

if TYPE_CHECKING:
    from membrane_rs.scene import Scene

SceneArgument = Annotated[str, typer.Argument(metavar="SCENE", help="A built-in scene, or the path of a TOML file.")]
Until = Annotated[float | None, typer.Option(help="Simulated time at the end (s). Default: the scene's.")]
Integrator = Annotated[str | None, typer.Option(help="Name of the method. Default: the scene's.")]
Dt = Annotated[float | None, typer.Option(help="Step (s). Default: from the stability limit, or from the tolerance.")]
Tolerance = Annotated[float | None, typer.Option(help="Tolerance for the error of dopri5. Default: the scene's.")]
SpectralRadius = Annotated[
    float | None,
    typer.Option(help="Amplification per step of modes that an implicit method cannot resolve: 0 to 1."),
]
Substeps = Annotated[
    int | None,
    typer.Option(help="Substeps of leapfrog in a step, for laws that are not slow. Default: the scene's."),
]
ShortSteps = Annotated[int | None, typer.Option("--short-steps", hidden=True, help="The old name of --substeps.")]
Out = Annotated[Path | None, typer.Option(help="Folder of the results. Default: runs/ and the scene's name.")]
Frames = Annotated[int | None, typer.Option(help="Number of shapes written, evenly spaced. Default: the scene's.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace an earlier run in the same folder.")]
Ensemble = Annotated[
    int | None, typer.Option(help="Number of runs from perturbed starts; 0: none. Default: depends on the study.")
]
Rows = Annotated[str, typer.Option(help="Mesh densities: rows of cells of a petal, separated by commas.")]
Jobs = Annotated[int | None, typer.Option(help="Number of parallel runs. Default: one on each core.")]
Checkpoint = Annotated[
    float, typer.Option(help="Seconds of wall time between two checkpoints, from which a killed run is resumed.")
]
NoPictures = Annotated[bool, typer.Option("--no-pictures", help="Draw no pictures at the end.")]


def load(scene: str) -> Scene:
    """A built-in scene by its name, or a scene file by its path (ending or slash)."""
    from membrane_rs import scenes as built_in
    from membrane_rs.scene import Scene

    if scene.endswith(".toml") or "/" in scene or Path(scene).is_file():
        return Scene.from_toml(scene)
    return built_in.load(scene)


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
