"""Commands for scene files of one's own: new, and schema."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from membrane_rs.cli.application import SCENES, Json, command, in_shell, print_json, tell
from membrane_rs.cli.options import Set

if TYPE_CHECKING:
    from membrane_rs.scene import Scene

SCHEMA_FILE = "membrane-rs.schema.json"
"""The JSON schema beside a new scene file."""
OF_DEVICES = "CON|PRN|AUX|NUL|(COM|LPT)[0-9]"
"""Names that Windows keeps for devices, whatever their ending."""
From = Annotated[
    str, typer.Option("--from", metavar="SCENE", help="A built-in scene, or the path of a TOML file, to begin with.")
]


@command(SCENES, example="new my-sail --from okuizumi-model-1 --set laws.spin.frequency=25rpm")
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Of the scene; NAME.toml is written, never replaced.")],
    *,
    source: From = "okuizumi-model-1",
    set_: Set = None,
    schema: Annotated[
        bool, typer.Option(help=f"Write {SCHEMA_FILE} beside it, by which editors check and help.")
    ] = True,
    json: Json = False,
) -> None:
    """Write a commented scene file of your own, from a built-in one or from another file."""
    from membrane_rs.cli.settings import values_of
    from membrane_rs.errors import InputError
    from membrane_rs.scene.commented import SCHEMA_LINE, with_comments
    from membrane_rs.scene.toml import pattern_name
    from membrane_rs.scenes import scene_of

    path = _path(name)
    if path.exists() or path.is_symlink():
        raise InputError(f"{path}: is there already, and is not replaced; choose another name")
    before = scene_of(source)
    text, folder = _text_of(source)
    own_mesh = before.mesh is not None and pattern_name(before.mesh) is None
    if own_mesh and (folder is None or folder.resolve() != path.parent.resolve()):
        raise InputError(f"--from {source}: its mesh is in a file beside it; write NAME into that folder: {folder}")
    made = before.with_values({**values_of(set_ or ()), "name": path.stem})
    text, kept = with_comments(text, before, made, path)
    if not kept:
        tell(f"The comments of {source} are left out, since its lines are not written as a key and a value each.")
    lines = [f"{SCHEMA_LINE}./{SCHEMA_FILE}"] if schema and _write_schema(path.with_name(SCHEMA_FILE)) else []
    lines += [f"# Made from {' '.join(source.split())}.", "#" if text.startswith("#") else "", text]
    _write(path, "\n".join(lines))
    if json:
        print_json({"file": str(path), "source": source})
        return
    typer.echo(f"Wrote {path}, from {source}\n")
    word = in_shell(path)
    typer.echo(f"  membrane-rs check {word}    # faults and risks, step, cost\n  membrane-rs run {word}")
    _tell_of(made)


@command(SCENES, example="schema")
def schema() -> None:
    """Print the JSON schema of scene files, by which editors such as Even Better TOML check them and help."""
    from membrane_rs.scene.schema import schema as made

    print_json(made())


def _tell_of(scene: Scene) -> None:
    """Say what is worth changing first."""
    if scene.mesh is not None and scene.material is not None:
        tell('\nNumbers are in SI units; a text may have its unit: thickness = "12.5 um".')


def _path(name: str) -> Path:
    """Where a scene of a name is written. Raises InputError."""
    from membrane_rs._files import path_of
    from membrane_rs._messages import show
    from membrane_rs.errors import InputError

    path = path_of(name, "NAME")
    if path.name in ("", ".toml", "..") or name.endswith(("/", os.sep)):
        folder = path.parent if path.name == ".toml" else path
        raise InputError(f"NAME = {name!r}: names no file; write one such as {(folder / 'my-sail').as_posix()}")
    if not path.name.isprintable() or len(os.fsencode(path.name)) > 200:
        raise InputError(f"NAME = {show(name)}: must be at most 200 bytes that can be printed; write my-sail")
    if re.fullmatch(OF_DEVICES, path.name.partition(".")[0].rstrip(), re.IGNORECASE):
        raise InputError(f"NAME = {name!r}: is a device of Windows, where no file has that name; write my-sail")
    if path.suffix != ".toml":
        path = path.with_name(f"{path.name}.toml")
    if not path.parent.is_dir():
        what = "is no folder; choose one" if path.parent.exists() else "there is none; make it first"
        raise InputError(f"NAME = {name!r}: its folder {path.parent}: {what}")
    return path


def _text_of(source: str) -> tuple[str, Path | None]:
    """The text of a scene file, and its folder; None for a built-in scene."""
    from membrane_rs import scenes
    from membrane_rs._files import read_text

    if source in scenes.names() and not Path(source).is_file():
        return scenes.text(source), None
    return read_text(Path(source)), Path(source).parent


def _write_schema(path: Path) -> bool:
    """Write the schema, unless another file is there; whether one is."""
    import json

    from membrane_rs.scene.schema import schema as made

    text = json.dumps(made(), indent=1) + "\n"
    if not path.exists():
        _write(path, text)
    elif path.read_text(encoding="utf-8", errors="replace") != text:
        tell(f"{path} is there already, and is left as it is; membrane-rs schema prints that of this version.")
    return True


def _write(path: Path, text: str) -> None:
    """Write a new file. Raises OutputError, also where there is one."""
    from membrane_rs._files import output_errors

    with output_errors(path), path.open("x", encoding="utf-8") as file:
        try:
            file.write(text)
            file.flush()
        except OSError:
            path.unlink(missing_ok=True)
            raise
