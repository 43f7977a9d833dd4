"""The command export: the mesh of a scene, for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from membrane_rs.cli.application import SCENES, Json, command, print_json
from membrane_rs.cli.options import ReplaceMesh, SceneArgument, Set, load, path_option, refuse_existing


@command(SCENES, example="export okuizumi-model-1 --out sail.fold")
def export(
    scene: SceneArgument,
    *,
    out: Annotated[
        Path | None, path_option(help="The file, which ends in .fold or .npz. Default: the scene's name and .fold.")
    ] = None,
    set_: Set = None,
    overwrite: ReplaceMesh = False,
    json: Json = False,
) -> None:
    """Write the mesh of a scene, flat and stowed, with its creases, as a FOLD file or a numpy archive."""
    from membrane_rs.errors import InputError
    from membrane_rs.mesh import write_fold

    chosen = load(scene, set_)
    if chosen.mesh is None:
        raise InputError(f"the scene {chosen.name} has no membrane, and so no mesh; name another one")
    path = out or Path(f"{chosen.name}.fold")
    refuse_existing(path, overwrite)
    if path.suffix == ".fold":
        write_fold(path, chosen.mesh, title=chosen.name)
    else:
        chosen.mesh.save(path)
    counts = {"nodes": chosen.mesh.node_count, "triangles": len(chosen.mesh.triangles)}
    if json:
        print_json({"file": str(path), **counts, "creases": len(chosen.mesh.creases)})
        return
    typer.echo(f"Wrote {path}: {', '.join(f'{count:,} {name}' for name, count in counts.items())}")
