"""What a shell completes: scenes, runs, methods, dotted keys. Where nothing fits, the shell offers files itself."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

import typer

RUNS = "runs"
"""The folder in which runs are written where no other is named."""
MOST = 1000
"""Entries of a folder that are looked at."""


def scenes(incomplete: str) -> list[tuple[str, str]]:
    """The built-in scenes, with what they are, and scene files here."""
    from membrane_rs import scenes as built_in

    found = [(name, built_in.describe(name)) for name in built_in.names() if name.startswith(incomplete)]
    if "/" not in incomplete:
        found += [(_word(path), "scene file") for path in _entries(Path()) if path.suffix == ".toml"]
    return found


def runs(incomplete: str) -> list[str]:
    """Folders of runs in the folder that is begun, or here and in runs/."""
    begun = incomplete.rpartition("/")[0]
    places = [Path(begun)] if begun else [Path(), Path(RUNS)]
    return [_word(path) for place in places for path in _entries(place) if (path / "summary.json").is_file()]


def runs_and_scenes(incomplete: str) -> list[tuple[str, str]]:
    """Both."""
    return [*((run, "run") for run in runs(incomplete)), *scenes(incomplete)]


def methods(incomplete: str) -> list[str]:
    """Methods of integration."""
    from membrane_rs import integrators

    return [name for name in integrators() if name.startswith(incomplete)]


def measures(incomplete: str) -> list[tuple[str, str]]:
    """Known measures, with their units."""
    from membrane_rs.scene.stage import MEASURE_UNITS

    return [(name, unit or "-") for name, unit in MEASURE_UNITS.items() if name.startswith(incomplete)]


def keys(context: typer.Context, incomplete: str) -> list[str]:
    """Dotted keys of the scene that stands before the option, each with its equals sign."""
    from membrane_rs.errors import MembraneError
    from membrane_rs.scene.values import keys_of
    from membrane_rs.scenes import scene_of

    words = [
        context.params.get("scene"),
        context.params.get("source"),
        *context.args,
    ]  # where an option lacks its value, words are not yet taken
    try:
        scene = scene_of(next((str(word) for word in words if word), ""))
    except (MembraneError, OSError):
        return []
    return [f"{key}=" for key in keys_of(scene) if key.startswith(incomplete)]


def _word(path: Path) -> str:
    """A path as the shell puts it on its line: bash takes what it is offered as it is, the others quote it."""
    is_bash = os.environ.get("_MEMBRANE_RS_COMPLETE") == "complete_bash"
    return re.sub(r"([^\w@%+=:,./-])", r"\\\1", str(path)) if is_bash else str(path)


def _entries(place: Path) -> Iterator[Path]:
    """What is in a folder, in order; nothing where it cannot be read."""
    try:
        yield from sorted(place.iterdir())[:MOST]
    except OSError:
        return
