"""The deployment of a run in 3D: which frames and fields the page holds, as arrays for its viewer (assets/viewer.js).

Coordinates are rounded to 1/32767 of half the size of all frames, fields to 255 steps of their scale, frames are left
out evenly, where all would take more than a share of the page.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats, Ints
from membrane_rs.errors import OutputError
from membrane_rs.mesh.queries import find_pairs
from membrane_rs.plotting import picture
from membrane_rs.plotting.animation import smoothed
from membrane_rs.plotting.camera import ANGLE_DEG, MARGIN, Camera
from membrane_rs.plotting.columns import axis_label, prefixed
from membrane_rs.plotting.drawing import decimals
from membrane_rs.plotting.fields import BARE, FIELDS, MISSING, SHARE, Field, range_with
from membrane_rs.plotting.picture import FARTHEST, Color, Subject, is_drawable
from membrane_rs.plotting.scenery import BodiesInTime, cylinder_ends, plane_corners, reach_of
from membrane_rs.plotting.stage_marks import stage_starts
from membrane_rs.plotting.web import hex_of, scale_colors
from membrane_rs.report.packing import category_levels, coordinates, levels, packed
from membrane_rs.scene import Scene
from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.solid import Solid
from membrane_rs.simulation.timeline import StageRecord

if TYPE_CHECKING:
    from membrane_rs.runs import Run, RunFrame

MOST_BYTES = 24_000_000
"""Of the arrays of all runs in a page, before they are compressed to about a half."""
FEWEST_FRAMES = 12
"""Rather than so few frames, less fields are kept."""
MOST_FRAMES = 1000
"""Two minutes at the speed of 1."""
FEWEST = 3
"""A run of which so few frames would fit is not shown in 3D."""
FOR_CAMERA = 24
TICKS = 5
LINE = "#3a3632"
LINE_SHARE, CORD_SHARE, TIP_SHARE = 0.0016, 0.004, 0.011
"""Radii of lines, of those of a scene without a film, and of tip masses, over what the camera reaches."""
CLOSER = 0.9
"""Nearer than the camera of square pictures, where all is still seen: the page is wider than high."""
FOLLOWS = 1.5
"""The camera can follow the size of the shape where that grows by more."""
_FAR = f"their positions are not finite, or beyond {FARTHEST:g} m"


@dataclass(frozen=True)
class Shown:
    """A run in 3D: what its viewer is given, `meta` as JSON and `data` as base64; or a note why there is nothing."""

    meta: dict[str, Any] | None
    data: str
    note: str


@dataclass(frozen=True)
class Staged:
    """A scene, its arrays at the start, and the stages of a run that have begun."""

    scene: Scene
    assembly: Assembly
    stages: Sequence[StageRecord]

    @classmethod
    def of(cls, run: Run) -> Staged:
        """Of a run, finished or not: one that goes on has no records of its stages, but their starts in its history."""
        names = [stage.name for stage in run.scene.stages]
        began = [(names[k], time) for k, time in stage_starts(run.history) if 0 <= k < len(names)]
        records = [StageRecord(name, time, time, None, "", 0.0, 0, 0, 0, {}, {}, 0.0, 0.0) for name, time in began]
        first = run.scene.staged(0) if run.scene.stages else run.scene
        return cls(run.scene, first.assemble(), records)

    def subject(self, shapes: Sequence[Floats]) -> Subject:
        """What is drawn; its `shapes`, (N, 3) [m] each, fit in."""
        return Subject.of_scene(self.scene, self.assembly, shapes)

    def bodies(self, stowed: Floats) -> BodiesInTime:
        """The bodies at each time; `stowed` (N, 3) [m] gives endless ones their ends."""
        return BodiesInTime.of_scene(self.scene, self.stages, stowed)


def deployment(run: Run, share: float = 1.0) -> Shown:
    """The frames of a run for the viewer, in a share of the bytes of a page. Raises OutputError for damaged frames."""
    if not len(run.frames):
        return Shown(None, "", "This run has no frames, so there is no shape to show. Run it with frames.")
    first = run.frames[0]
    fields = [
        field
        for field in FIELDS.values()
        if field.values(first) is not None or field.values(run.frames[-1]) is not None
    ]
    budget = share * MOST_BYTES
    while fields and budget / _frame_bytes(first, fields) < min(FEWEST_FRAMES, len(run.frames)):
        fields = fields[:-1]
    most = min(MOST_FRAMES, int(budget / _frame_bytes(first, fields)))
    if most < min(FEWEST, len(run.frames)):
        size = f"{len(first.positions):,} nodes and {len(first.triangles):,} triangles"
        return Shown(None, "", f"The shape is too large for this page: {size}. Look at it with `membrane-rs view`.")
    picks = np.unique(np.linspace(0, len(run.frames) - 1, min(len(run.frames), most)).round().astype(int))
    frames = _Frames.read(run, picks.tolist(), fields)
    count = len(frames.times)
    if not count:
        return Shown(None, "", f"No frame of this run can be drawn: {_FAR}.")
    note = "" if count == len(run.frames) else f"{count} of the run's {len(run.frames)} frames. "
    if count < len(picks):
        note += f"{len(picks) - count} cannot be drawn: {_FAR}. "
    fields = [field for field in fields if np.isfinite(frames.values[field.name]).any()]
    return _shown(Staged.of(run), frames, fields, note)


def _frame_bytes(frame: RunFrame, fields: Sequence[Field]) -> int:
    """Bytes of a frame in the page."""
    counts = {"nodes": len(frame.positions), "triangles": len(frame.triangles), "lines": len(frame.lines)}
    return 6 * len(frame.positions) + sum(counts[field.place] for field in fields)


@dataclass(frozen=True)
class _Frames:
    """Some frames of a run, read once: (F, N, 3) positions [m], and (F, n) values of each field."""

    times: list[float]
    hub_angles: list[float]
    stages: list[int]
    positions: Floats
    values: dict[str, NDArray[np.float32]]
    triangles: Ints
    lines: Ints

    @classmethod
    def read(cls, run: Run, picks: Sequence[int], fields: Sequence[Field]) -> _Frames:
        """Those of some indices."""
        first = run.frames[picks[0]]
        counts = {"nodes": len(first.positions), "triangles": len(first.triangles), "lines": len(first.lines)}
        positions = np.zeros((len(picks), len(first.positions), 3))
        values = {field.name: np.full((len(picks), counts[field.place]), np.nan, np.float32) for field in fields}
        times: list[float] = []
        angles: list[float] = []
        stages: list[int] = []
        for index in picks:
            frame = run.frames[index]
            if (len(frame.positions), len(frame.triangles), len(frame.lines)) != tuple(counts.values()):
                where = f"frame {index} at {frame.time:g} s"
                raise OutputError(f"{where} has other nodes or cells than the first one; run the scene again")
            if not (is_drawable(frame.positions) and math.isfinite(frame.time)):
                continue  # of a run that was stopped too late, or of a damaged file
            k = len(times)
            times.append(float(frame.time))
            angles.append(float(frame.hub_angle) if math.isfinite(frame.hub_angle) else 0.0)
            stages.append(int(frame.stage))
            positions[k] = frame.positions
            for field in fields:
                found = field.values(frame)
                if found is not None:
                    values[field.name][k] = found
        kept = {name: rows[: len(times)] for name, rows in values.items()}
        triangles, lines = np.asarray(first.triangles), np.asarray(first.lines)
        return cls(times, angles, stages, positions[: len(times)], kept, triangles, lines)


def _shown(staged: Staged, frames: _Frames, fields: Sequence[Field], note: str) -> Shown:
    some = frames.positions[:: max(1, len(frames.positions) // FOR_CAMERA)]
    shapes = [*some, frames.positions[-1]]
    subject = staged.subject(shapes)
    bodies = staged.bodies(frames.positions[0])
    solids = [bodies.at(time) for time in frames.times]
    reaches = [reach_of(shape, beside) for shape, beside in zip(frames.positions, solids, strict=True)]
    reach = max([subject.reach, *reaches]) if subject.has_hub else subject.reach
    can_follow = subject.has_hub and len(reaches) > 1 and max(reaches) > FOLLOWS * min(reaches)
    centre = 0.5 * (frames.positions.min(axis=(0, 1)) + frames.positions.max(axis=(0, 1)))
    half = float(np.abs(frames.positions - centre).max()) or 1.0
    camera = subject.camera
    names = [stage.name for stage in staged.scene.stages]
    cylinders, planes = _solid_arrays(solids, subject)
    arrays: dict[str, NDArray[Any]] = {
        "positions": coordinates(frames.positions, centre, half),
        "triangles": frames.triangles.astype(np.uint32),
        "lines": frames.lines.astype(np.uint32),
        "petals": np.where(subject.petals < 0, 0, subject.petals % len(picture.PETALS)).astype(np.uint8),
        "outline": _outline(staged.assembly, frames),
        "tips": np.unique(subject.tips).astype(np.uint32),
        "solids": cylinders.astype(np.float32),
        "planes": planes.astype(np.float32),
    }
    described = []
    for field in fields:
        found = frames.values[field.name]
        low, high = _ends(field, found)
        described.append(_description(field, low, high, found))
        if field.place == "lines":
            rows = np.flatnonzero(np.isfinite(found).any(axis=0))
            arrays[f"{field.name}-lines"], found = rows.astype(np.uint32), found[:, rows]
        arrays[field.name] = (
            category_levels(found, len(field.categories)) if field.categories else levels(found, low, high)
        )
    data, places = packed(arrays)
    tones = picture.PETALS if (subject.petals >= 0).any() else (picture.PLAIN,)
    meta = {
        "arrays": places,
        "node_count": frames.positions.shape[1],
        "triangle_count": len(frames.triangles),
        "line_count": len(frames.lines),
        "solid_count": cylinders.shape[1],
        "plane_count": planes.shape[1],
        "times": frames.times,
        "digits": decimals(frames.times, 3),
        "hub_angles": frames.hub_angles,
        "stages": [names[k] if 0 <= k < len(names) else "" for k in frames.stages],
        "centre": centre.tolist(),
        "half": half,
        "spool": subject.spool,
        "turns": subject.has_hub,
        "can_follow": can_follow,
        "follows": bool(can_follow and names),
        "reaches": smoothed(reaches) if can_follow else [reach] * len(reaches),
        "reach": reach,
        "distance": max(CLOSER * camera.distance, _nearest(camera, shapes, subject.has_hub)) * reach / camera.reach,
        "centre_of_view": camera.centre.tolist(),
        "view": camera.view.tolist(),
        "up": camera.up.tolist(),
        "line_radius": (LINE_SHARE if len(frames.triangles) else CORD_SHARE) * reach,
        "tip_radius": TIP_SHARE * reach,
        "line_color": LINE,
        "missing": hex_of(MISSING),
        "bare": hex_of(BARE),
        "front": [_hex(tone) for tone in tones],
        "back": [_hex(_mixed(tone)) for tone in tones],
        "fields": described,
    }  # fmt: skip
    size, unit = prefixed("m", [np.array([half / 32767])])
    rounded = (
        f"Coordinates are rounded to {half / 32767 / size:.2g} {unit}, and interpolated between frames while it plays."
    )
    return Shown(meta, data, f"{note}{rounded}")


def _nearest(camera: Camera, shapes: Sequence[Floats], turns: bool) -> float:
    """Distance from which the picture holds all shapes from top to bottom, also as they turn about z [m]."""
    points = np.concatenate(shapes) - camera.centre
    if turns:
        ahead = camera.view if np.hypot(*camera.view[:2]) > 0.0 else camera.up
        radii = np.hypot(points[:, :1], points[:, 1:2]) * ahead[:2] / np.hypot(*ahead[:2])
        points = np.concatenate([np.hstack([side * radii, points[:, 2:]]) for side in (-1.0, 1.0)])
    half = float(np.tan(np.radians(0.5 * ANGLE_DEG)))
    return float((MARGIN * np.abs(points @ camera.up) / half + points @ camera.view).max())


def _ends(field: Field, values: NDArray[np.float32]) -> tuple[float, float]:
    """Both ends of the scale: `SHARE` of the values of each frame lie between them."""
    ends = None
    for row in values:
        if np.isfinite(row).any():
            ends = range_with(field, row, SHARE, ends)
    return ends or (0.0, 0.0)


def _description(field: Field, low: float, high: float, values: NDArray[np.float32]) -> dict[str, Any]:
    """What the viewer needs of a field."""
    ticks, note, unit = list(field.categories), "", field.unit
    if not field.categories:
        ends = np.array([low, high, float(np.nanmin(values)), float(np.nanmax(values))])
        factor, unit = prefixed(unit, [ends])
        low, high, least, most = (ends / factor).tolist()
        ticks = [f"{value:.3g}" for value in np.linspace(low, high, TICKS)]
        note = f"{100.0 * SHARE:g} % of each frame's values lie on this scale, all from {least:.3g} to {most:.3g}"
    return {
        "name": field.name, "title": axis_label(field.label, unit), "place": field.place,
        "is_stepped": bool(field.categories), "colors": scale_colors(field), "ticks": ticks, "note": note,
    }  # fmt: skip


def _hex(color: Color | Sequence[float]) -> str:
    return "#" + "".join(f"{round(255 * part):02x}" for part in color)


def _mixed(tone: Color) -> list[float]:
    """The tone of the other face."""
    share = picture.BACK_SHARE
    return [(1.0 - share) * one + share * back for one, back in zip(tone, picture.BACK, strict=True)]


def _outline(assembly: Assembly, frames: _Frames) -> NDArray[np.uint32]:
    """Rows of the lines that are drawn beside the film: its edge, creases and cords."""
    sides = np.sort(frames.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    pairs, counts = np.unique(sides, axis=0, return_counts=True) if len(sides) else (sides, np.zeros(0, int))
    wanted = np.concatenate([pairs[counts == 1], assembly.creases.nodes, assembly.cords.nodes])
    rows = find_pairs(frames.lines, wanted)
    return np.unique(rows[rows >= 0]).astype(np.uint32)


def _solid_arrays(solids: Sequence[Sequence[Solid]], subject: Subject) -> tuple[Floats, Floats]:
    """Cylinders (F, c, 7), both ends and the radius, which is 0 where there are fewer; planes (F, p, 4, 3) [m]."""
    cylinders = [[solid for solid in some if solid.radius is not None] for some in solids]
    planes = [[solid for solid in some if solid.radius is None] for some in solids]
    rows = np.zeros((len(solids), max(map(len, cylinders), default=0), 7))
    corners = np.zeros((len(solids), max(map(len, planes), default=0), 4, 3))
    for k, some in enumerate(cylinders):
        for n, solid in enumerate(some):
            rows[k, n] = np.concatenate([*cylinder_ends(solid), [solid.radius or 0.0]])
    for k, some in enumerate(planes):
        for n, solid in enumerate(some):
            corners[k, n] = plane_corners(solid, subject.camera)
    return rows, corners
