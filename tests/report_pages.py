"""Runs that pages are made of in tests."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import membrane_rs
from fake_simulation import small_sail
from membrane_rs import Run, Scene, Stage

UNTIL, FRAMES = 0.02, 11


def sail(**changes: Any) -> Scene:
    """A small sail that unfolds for a while."""
    return replace(small_sail(snapshots=(), dt=4e-6, samples=41), **changes)


def staged_sail() -> Scene:
    """The same in two stages."""
    return sail(stages=(Stage("hold </script>", UNTIL / 2, frames=4), Stage("let go", UNTIL / 2, frames=5)))


def made(scene: Scene, folder: Path, **options: Any) -> Run:
    """A run of a scene in a folder, without pictures."""
    until = None if scene.stages else options.pop("until", UNTIL)
    wanted = {"frames": FRAMES} if not scene.stages else {}
    return membrane_rs.run(scene, until, out=folder, pictures=False, **{**wanted, **options})
