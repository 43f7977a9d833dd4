"""The words of the commands: arguments and options that several share, and what they mean."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from membrane_rs.scene import Scene

SceneArgument = Annotated[str, typer.Argument(metavar="SCENE", help="A built-in scene, or the path of a TOML file.")]
Until = Annotated[float | None, typer.Option(help="Simulated time at the end [s]. Default: the scene's.")]
Integrator = Annotated[str | None, typer.Option(help="Name of the method. Default: the scene's.")]
Dt = Annotated[float | None, typer.Option(help="Step [s]. Default: from the stability limit, or from the tolerance.")]
Tolerance = Annotated[float | None, typer.Option(help="Error of a step that dopri5 chooses. Default: the scene's.")]
SpectralRadius = Annotated[
    float | None, typer.Option(help="What an implicit method leaves, per step, of vibrations too fast for it: 0 to 1.")
]
ShortSteps = Annotated[
    int | None,
    typer.Option(help="Short steps in a step of leapfrog, for laws that are not slow. Default: the scene's."),
]
Out = Annotated[Path | None, typer.Option(help="Folder of the results. Default: runs/ and the scene's name.")]
Frames = Annotated[int | None, typer.Option(help="Shapes written, evenly spaced. Default: the scene's.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace an earlier run in the same folder.")]
Ensemble = Annotated[int | None, typer.Option(help="Runs from perturbed starts; 0: none. Default: a few, or none.")]
Rows = Annotated[str, typer.Option(help="Rows of cells of a petal, parted by commas: the densities of the mesh.")]
Jobs = Annotated[int | None, typer.Option(help="Runs at once. Default: one on each core.")]
NoPictures = Annotated[bool, typer.Option("--no-pictures", help="Draw nothing at the end.")]


def load(scene: str) -> Scene:
    """A built-in scene by name; a path by its ending or its slash."""
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
    """Numbers parted by commas. Raises InputError, which names the option."""
    from membrane_rs.errors import InputError

    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        raise InputError(f"{option} = {text!r}: must be numbers parted by commas") from None


def whole(number: float, option: str) -> int:
    """A whole number from 1 on. Raises InputError, which names the option."""
    from membrane_rs.errors import InputError

    if not number.is_integer() or number < 1:
        raise InputError(f"{option} = {number:g}: must be whole numbers from 1 on, parted by commas")
    return int(number)
