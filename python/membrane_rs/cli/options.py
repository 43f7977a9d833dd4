"""Arguments and options that several commands share, and their values."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from membrane_rs._messages import show
from membrane_rs._numbers import AUTO
from membrane_rs._renamed import deprecated
from membrane_rs.cli import completion
from membrane_rs.cli.application import say_in

if TYPE_CHECKING:
    from membrane_rs.mesh.findings import Audit
    from membrane_rs.runs import Simulation
    from membrane_rs.scene import Scene


def number(text: str) -> float:
    """A number of the command line. Raises BadParameter, which names the value and what to write."""
    try:
        return float(text)
    except ValueError:
        raise typer.BadParameter(f"{show(text)}: must be a number, such as 0.5") from None


def number_or_text(text: str) -> Any:
    """A number, or a text, which may have a unit."""
    with suppress(ValueError):
        return float(text)
    return text


def quantity(text: str, unit: str) -> float:
    """A number of the command line, or a text with its unit, in SI. Raises BadParameter, which names the value."""
    with suppress(ValueError):
        return float(text)
    from membrane_rs._quantities import to_si
    from membrane_rs.errors import InputError

    try:
        return to_si(text, unit, "")
    except InputError as error:
        raise typer.BadParameter(str(error)) from None


def count(text: str) -> int:
    """A whole number of the command line. Raises BadParameter, which names the value."""
    try:
        return int(text)
    except ValueError:
        raise typer.BadParameter(f"{show(text)}: must be a whole number, such as 10") from None


def numeric_option(help: str) -> Any:  # noqa: A002 - typer's own word
    """An option that takes a number."""
    return typer.Option(help=help, parser=number, metavar="FLOAT")


def quantity_option(unit: str, help: str) -> Any:  # noqa: A002 - typer's own word
    """An option that takes a number in a unit, which the help names, or a text with its unit."""

    def parser(text: str) -> float:  # click names a type by its function, which a partial one lacks
        return quantity(text, unit)

    return typer.Option(help=help, parser=parser, metavar="QUANTITY")


def step(text: str) -> float | str:
    """A step of the command line [s], or "auto" as it is. Raises BadParameter, which names the value."""
    return AUTO if text.strip() == AUTO else quantity(text, "s")


def path(text: str | Path) -> Path:
    """A path of the command line, or a default. Raises BadParameter for an empty one, which would be this folder."""
    if not str(text).strip():
        raise typer.BadParameter(f"{show(text)}: must be a path; name a file or a folder")
    return Path(text)


def path_option(help: str) -> Any:  # noqa: A002 - typer's own word
    """An option that takes a path."""
    return typer.Option(help=help, parser=path, metavar="PATH")


def count_option(help: str) -> Any:  # noqa: A002 - typer's own word
    """An option that takes a whole number."""
    return typer.Option(help=help, parser=count, metavar="INTEGER")


SceneArgument = Annotated[
    str,
    typer.Argument(
        metavar="SCENE", help="A built-in scene, or the path of a TOML file.", autocompletion=completion.scenes
    ),
]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        autocompletion=completion.keys,
        help="A value in place of the scene's: laws.creases.stiffness=20, material.thickness=12.5um, "
        "laws.spin.frequency=25rpm, mesh.fold_lines=3, laws.air_drag=false. May be given several times.",
    ),
]
Until = Annotated[
    float | None, quantity_option("s", help="Simulated time at the end [s], or as 20ms. Default: the scene's.")
]
Integrator = Annotated[
    str | None, typer.Option(help="Name of the method. Default: the scene's.", autocompletion=completion.methods)
]
Dt = Annotated[
    Any,  # a number, AUTO or None; typer takes no unions
    typer.Option(
        help="Step [s], or as 2us. auto: from stability and slow motion, with dopri5 by its error. Default: the "
        "scene's, else auto.",
        parser=step,
        metavar="QUANTITY|auto",
    ),
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
ShortSteps = Annotated[
    int | None,
    typer.Option("--short-steps", hidden=True, help="The old name of --substeps.", parser=count, metavar="INTEGER"),
]
Out = Annotated[Path | None, path_option(help="Folder of the results. Default: in runs/, named by the scene.")]
Frames = Annotated[int | None, count_option(help="Number of shapes written, evenly spaced. Default: the scene's.")]
Samples = Annotated[int | None, count_option(help="Rows of the history, evenly spaced. Default: the scene's.")]
RecordNames = Annotated[
    list[str] | None,
    typer.Option(
        "--record",
        metavar="NAME",
        autocompletion=completion.measures,
        help="A further measure in the history, such as largest_speed. May be given several times.",
    ),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace an earlier run in the same folder.")]
Rows = Annotated[str, typer.Option(help="Mesh densities: rows of cells of a petal, separated by commas.")]
Jobs = Annotated[int | None, count_option(help="Number of parallel runs. Default: one on each core.")]
Checkpoint = Annotated[
    float, quantity_option("s", help="Wall time between two checkpoints [s], from which a killed run is resumed.")
]
ReplaceMesh = Annotated[bool, typer.Option("--overwrite", help="Replace the mesh file.")]
NoPictures = Annotated[bool, typer.Option("--no-pictures", help="Draw no pictures at the end.")]


def load(scene: str, values: list[str] | None = None) -> Scene:
    """A built-in scene by its name, or a scene file by its path (ending or slash), with the values of `--set`."""
    from membrane_rs.cli.settings import values_of
    from membrane_rs.scenes import scene_of

    found = scene_of(scene)
    return found.with_values(values_of(values)) if values else found


def refuse_existing(path: Path, overwrite: bool) -> None:
    """Refuse a file that is there already, unless it is to be replaced."""
    from membrane_rs.errors import InputError

    if path.exists() and not overwrite:
        raise InputError(f"{path}: is there already; choose another name by --out, or replace it by --overwrite")


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
        say_in("yellow" if found.ok else "red", f"Audit: {found}")


def with_settings(scene: Scene, wanted: dict[str, Any]) -> Scene:
    """The scene with the run settings that were given on the command line."""
    from dataclasses import asdict, replace

    from membrane_rs._validation import build
    from membrane_rs.scene.run_settings import RunSettings

    given = {name: value for name, value in wanted.items() if value is not None}
    return replace(scene, run=build(RunSettings, asdict(scene.run) | given, "run")) if given else scene


def numbers(text: str, option: str, unit: str = "") -> list[float]:
    """Numbers, or texts with their units, separated by commas, in SI. Raises InputError, which names the option."""
    from membrane_rs._quantities import to_si
    from membrane_rs.errors import InputError, InputTypeError

    found = []
    for word in text.split(","):
        try:
            found.append(float(word))
        except ValueError:
            try:
                found.append(to_si(word.strip(), unit, option))
            except InputTypeError:
                raise InputError(f"{option} = {text!r}: must be numbers separated by commas") from None
    return found


def words(text: str, option: str) -> list[str]:
    """Words separated by commas. Raises InputError, which names the option, for an empty one."""
    from membrane_rs.errors import InputError

    found = [word.strip() for word in text.split(",")]
    if not all(found):
        raise InputError(f"{option} = {text!r}: must be names separated by commas")
    return found


def refuse_given(options: Mapping[str, bool], why: str) -> None:
    """Refuse the options that are given, by their names. Raises InputError, which names the first of them."""
    from membrane_rs.errors import InputError

    for option, is_given in options.items():
        if is_given:
            raise InputError(f"{option}: {why}")


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
