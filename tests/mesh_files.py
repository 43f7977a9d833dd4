"""Mesh files as other programs write them, as text."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from numpy.typing import NDArray

GMSH_22 = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
4
0 1 "tip"
1 2 "held edge"
2 3 "film"
2 4 "left half"
$EndPhysicalNames
$Nodes
7
1 0 0 0
2 10 0 0
3 20 0 0
4 0 10 0
5 10 10 0
6 20 10 0
7 5 5 5
$EndNodes
$Elements
9
1 15 2 1 3 3
2 15 2 5 7 7
3 1 2 2 4 1 4
4 2 2 3 1 1 2 5
5 2 2 3 1 1 5 4
6 3 2 3 1 2 3 6 5
7 2 2 4 1 1 2 5
8 2 2 4 1 1 5 4
9 1 2 9 1 1 2
$EndElements
"""
"""Six nodes of two squares and one that is apart, [mm]: the left square of two triangles, the right one of one cell.
Elements of two groups stand twice, as version 2.2 has them; the groups 5 and 9 have no names."""
GMSH_41 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
4
0 1 "tip"
1 2 "held edge"
2 3 "film"
2 4 "left half"
$EndPhysicalNames
$Entities
2 2 2 0
3 20 0 0 1 1
7 5 5 5 1 5
4 0 0 0 0 10 0 1 2 0
9 0 0 0 10 0 0 1 9 0
1 0 0 0 10 10 0 2 3 4 0
2 10 0 0 20 10 0 1 3 0
$EndEntities
$Nodes
1 7 1 7
2 1 0 7
1
2
3
4
5
6
7
0 0 0
10 0 0
20 0 0
0 10 0
10 10 0
20 10 0
5 5 5
$EndNodes
$Elements
6 7 1 7
0 3 15 1
1 3
0 7 15 1
2 7
1 4 1 1
3 1 4
1 9 1 1
4 1 2
2 1 2 2
5 1 2 5
6 1 5 4
2 2 3 1
7 2 3 6 5
$EndElements
"""
"""The same mesh as version 4.1 has it: an entity has its groups."""
STL = """solid two squares
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 10 0 0
vertex 10 10 0
endloop
endfacet
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 10 10 0
vertex 0 10 0
endloop
endfacet
endsolid two squares
"""
OBJ = """# with what a modeller writes beside points and faces
mtllib none.mtl
o sail
v 0 0 0 0.5 0.5 0.5
v 10 0 0 0.5 0.5 0.5
v 10 10 0 0.5 0.5 0.5
v 0 10 0 0.5 0.5 0.5
vt 0 0
vn 0 0 1
g lower
f 1/1/1 2/1/1 3/1/1
g upper side
f -4//1 -2//1 \\
-1//1
"""


def grid(columns: int, rows: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Points and quadrilaterals of a grid of squares of side 1."""
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    index = np.arange((columns + 1) * (rows + 1)).reshape(rows + 1, columns + 1)
    corners = [index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]]
    return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1), np.stack(corners, axis=-1).reshape(-1, 4)


def halves(quads: NDArray[np.int64]) -> NDArray[np.int64]:
    """Quadrilaterals as triangles, all by the diagonal of their first corner."""
    return quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)


def write(
    path: Path, points: Any, cells: Iterable[tuple[str, Any]], file_format: str | None = None, **rest: Any
) -> Path:
    """A file by meshio, whose type is that of its name."""
    meshio.Mesh(np.asarray(points), [(kind, np.asarray(rows)) for kind, rows in cells], **rest).write(
        path, file_format=file_format
    )
    return path


def text_file(path: Path, text: str) -> Path:
    """A file of text."""
    path.write_text(text, encoding="utf-8")
    return path
