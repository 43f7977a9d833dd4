"""k3d in the page: its JavaScript, and a plot of the objects that the viewer (assets/viewer.js) fills.

k3d is under the MIT licence, whose text stands in the page.
"""

from __future__ import annotations

import base64
import re
from importlib import metadata
from pathlib import Path

from membrane_rs.plotting import picture
from membrane_rs.plotting.camera import ANGLE_DEG
from membrane_rs.report.packing import encoded

_FONT_FACE = re.compile(r"@font-face\{(?:\$\{[^}]*\}|[^}])*\}")
_FONT = re.compile(r"data:font/woff2;base64,[A-Za-z0-9+/=]+")
"""Those for formulas, of which the page has none: a third of the program, and they name files beside the page."""
_TRIANGLE = ([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2]])
_GREY = [0.0, 0.5, 0.5, 0.5, 1.0, 0.5, 0.5, 0.5]
FILM = {"roughness": 0.75, "metalness": 0.0, "flat_shading": True}


def source() -> str:
    """k3d's program, compressed, as base64."""
    folder = _folder()
    text = (folder / "static" / "standalone.js").read_text("utf-8")
    return encoded(_FONT.sub("data:,", _FONT_FACE.sub("", text)).encode())


def licence() -> str:
    """The licence of k3d and of what its program holds."""
    folder = _folder()
    texts = [
        metadata.distribution("k3d").read_text("licenses/LICENSE.txt") or "",
        (folder / "static" / "standalone.js.LICENSE.txt").read_text("utf-8"),
    ]
    return "\n\n".join(text.strip() for text in texts)


def _folder() -> Path:
    import k3d

    return Path(str(k3d.__file__)).parent


def plot() -> str:
    """A plot with one object of each kind, as k3d's snapshot in base64."""
    import k3d

    made = k3d.plot(
        camera_auto_fit=False, grid_auto_fit=False, grid_visible=False, menu_visibility=False, camera_fov=ANGLE_DEG,
        axes_helper=0.0, colorbar_object_id=0, antialias=2, lighting=1.7,
    )  # fmt: skip
    colored = {"attribute": [0.5, 0.5, 0.5], "color_map": _GREY, "color_range": [0.0, 1.0]}
    objects = [
        k3d.mesh(*_TRIANGLE, name="front", side="front", **colored, **FILM),
        k3d.mesh(*_TRIANGLE, name="back", side="back", **colored, **FILM),
        k3d.mesh(*_TRIANGLE, name="lines", **colored, flat_shading=True),
        k3d.mesh(*_TRIANGLE, name="tips", color=_number(picture.TIP), flat_shading=True),
        k3d.mesh(*_TRIANGLE, name="spool", color=_number(picture.SPOOL), flat_shading=True),
        k3d.mesh(*_TRIANGLE, name="bodies", color=_number(picture.BODY), flat_shading=True),
        k3d.mesh(*_TRIANGLE, name="mark", color=_number(picture.CORD)),
        k3d.mesh(*_TRIANGLE, name="planes", color=_number(picture.BODY), opacity=picture.PLANE_OPACITY, side="double"),
    ]
    for number, one in enumerate(objects, start=1):
        one.id = number
        made += one
    return base64.b64encode(made.get_binary_snapshot(9)).decode("ascii")


def _number(color: picture.Color) -> int:
    """A colour as k3d has it."""
    red, green, blue = (round(255 * part) for part in color)
    return (red << 16) + (green << 8) + blue
