"""The command that folds a flat crease pattern."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from membrane_rs.cli.application import SCENES, Json, command, print_json
from membrane_rs.cli.options import (
    ReplaceMesh,
    count_option,
    number_or_text,
    numeric_option,
    path_option,
    refuse_existing,
)
from membrane_rs.cli.progress import parts_counter


@command(SCENES, example="export single-crease --out crease.fold\nfold crease.fold --fraction 0.5 --out folded.npz")
def fold(
    pattern: Annotated[Path, typer.Argument(metavar="PATTERN", help="A FOLD file, or another file of a mesh.")],
    *,
    fraction: Annotated[
        float, numeric_option(help="Of the pattern's fold angles: above 0, flat, up to 1, as the pattern says.")
    ] = 1.0,
    scale: Annotated[
        Any,
        typer.Option(parser=number_or_text, metavar="UNIT", help="Unit of its coordinates: mm, or in metres, 0.001."),
    ] = None,
    divide: Annotated[
        int, count_option(help="Parts of each side of its triangles, at which panels can then bend.")
    ] = 1,
    increments: Annotated[int, count_option(help="Equal parts in which it is folded.")] = 10,
    facet_stiffness: Annotated[
        float, numeric_option(help="Bending stiffness of a panel over that of a crease; less lets panels bend.")
    ] = 0.3,
    strain_limit: Annotated[float, numeric_option(help="Strain from which on the pattern is refused.")] = 2e-3,
    force: Annotated[bool, typer.Option("--force", help="Write the shape also of a pattern that does not fold so.")] = (
        False
    ),
    out: Annotated[
        Path | None, path_option(help="The file, which ends in .npz or .fold. Default: PATTERN-folded.npz.")
    ] = None,
    overwrite: ReplaceMesh = False,
    json: Json = False,
) -> None:
    """Fold a flat crease pattern by simulation, for the start of a scene, and say how near it is to its angles."""
    from membrane_rs.errors import InputError
    from membrane_rs.mesh import Mesh
    from membrane_rs.simulation import fold as fold_pattern

    target = out or pattern.with_name(f"{pattern.stem}-folded.npz")
    refuse_existing(target, overwrite)
    if target.suffix not in {".npz", ".fold"}:
        raise InputError(f"--out = {str(target)!r}: must end in .npz or .fold")
    try:
        mesh = Mesh.read(pattern, scale=scale)
    except InputError as error:
        raise type(error)(str(error).replace("Mesh.read.", "--")) from error
    with parts_counter("increments") as show:
        found = fold_pattern(
            mesh if divide == 1 else mesh.divided(divide),
            fraction,
            increments=increments,
            facet_stiffness=facet_stiffness,
            strain_limit=strain_limit,
            force=force,
            progress=show,
        )
    found.mesh.save(target)
    if json:
        print_json({"file": str(target), **found.as_dict()})
        return
    typer.echo(found)
    for fault in found.faults:
        typer.echo(f"Fault: {fault}")
    typer.echo(f"Wrote {target}: {found.mesh.node_count:,} nodes, {len(found.mesh.triangles):,} triangles")
