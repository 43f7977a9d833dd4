"""The command that makes a mesh file of this package of one of another program."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from membrane_rs.cli.application import SCENES, Json, command, print_json
from membrane_rs.cli.options import ReplaceMesh, count_option, number_or_text, refuse_existing


@command(
    SCENES,
    example="run spinning-disc --until 0.0001 --no-pictures\n"
    "convert runs/spinning-disc/frames/frame-0000.vtu --scale m --out disc.npz",
)
def convert(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Of Gmsh, an OBJ, STL, VTU, or another mesh file.")],
    *,
    scale: Annotated[
        Any,
        typer.Option(parser=number_or_text, metavar="UNIT", help="Unit of its coordinates: mm, or in metres, 0.001."),
    ] = None,
    quads: Annotated[
        str | None,
        typer.Option(metavar="RULE", help="How quadrilaterals are split: shorter (the default) or alternate."),
    ] = None,
    merge: Annotated[
        Any,
        typer.Option(parser=number_or_text, metavar="LENGTH", help="Nodes no further apart become one [m]: 1um."),
    ] = None,
    frame: Annotated[
        int | None, count_option(help="Of a FOLD file: the frame that is the shape at the start; 0 is the key frame.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="The mesh file, NAME.npz. Default: beside FILE, by its name.")
    ] = None,
    overwrite: ReplaceMesh = False,
    json: Json = False,
) -> None:
    """Make a mesh file (.npz) of one that another program wrote, and say what was done."""
    from membrane_rs.errors import InputError
    from membrane_rs.mesh import Mesh, MeshOrigin

    target = file.with_suffix(".npz") if out is None else out
    refuse_existing(target, overwrite)
    try:
        mesh = Mesh.read(file, scale=scale, quads=quads, merge=merge, frame=frame)
    except InputError as error:
        raise type(error)(str(error).replace("Mesh.read.", "--")) from error
    mesh.save(target)
    sets: dict[str, dict[str, int]] = {
        kind: {name: len(members) for name, members in getattr(mesh, kind).items()}
        for kind in ("node_sets", "triangle_sets")
    }
    if json:
        origin = mesh.source._asdict() if isinstance(mesh.source, MeshOrigin) else None
        print_json(
            {"file": str(target), "nodes": mesh.node_count, "triangles": len(mesh.triangles), **sets, "of": origin}
        )
        return
    sides = " x ".join(f"{side:.4g}" for side in mesh.reference.max(axis=0) - mesh.reference.min(axis=0))
    typer.echo(mesh.source or file)
    typer.echo(f"Wrote {target}: {mesh.node_count} nodes, {len(mesh.triangles)} triangles, {sides} m")
