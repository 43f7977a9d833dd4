"""The recipes of CONTRIBUTING.md, carried out on toys that live here alone: a pattern, a part, an output."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
import pytest
from fake_simulation import summary
from membrane_rs import Fixed, Gravity, Scene, Simulation, Springs
from membrane_rs._files import write_text
from membrane_rs._validation import Count, Positive, Unit, validated
from membrane_rs.check.redundancy import idle_laws, step_savings
from membrane_rs.errors import InputError, OutputError
from membrane_rs.folding import PATTERNS, Pattern
from membrane_rs.folding.pattern import RowPattern, multiplied
from membrane_rs.mesh import Mesh
from membrane_rs.plotting.picture import Subject
from membrane_rs.results.record import Record
from membrane_rs.results.writer import Writer
from membrane_rs.runs import run_folder
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.cord import Cord
from membrane_rs.scene.parts import PARTS, Part
from membrane_rs.simulation import Stepper
from membrane_rs.study.common.density import denser
from membrane_rs.study.mesh import jobs_of, kept
from membrane_rs.study.variants import variants
from small_scenes import RUBBER, refused


@validated
class Ladder(Pattern):
    """Cells in one row along x, each of two triangles."""

    length: Annotated[Positive, Unit("m")]
    cells: Count

    def mesh(self) -> Mesh:
        """The flat ladder."""
        side, k = self.length / self.cells, np.arange(self.cells)
        rails = [np.stack([side * np.arange(self.cells + 1), np.full(self.cells + 1, y)], axis=1) for y in (0.0, side)]
        points = np.hstack([np.concatenate(rails), np.zeros((2 * self.cells + 2, 1))])
        low, high = k, k + self.cells + 1
        triangles = np.stack([low, low + 1, high + 1, low, high + 1, high], axis=1).reshape(-1, 3)
        return Mesh(points, triangles, node_sets={"start": [0, self.cells + 1]}, source=self)

    def refined(self, density: float) -> Ladder:
        return replace(self, cells=multiplied(self, density, "cells", self.cells))


class Plain:
    """A pattern of a user's own that derives from nothing, in rows."""

    def __init__(self, rows: int) -> None:
        self.rows = rows

    def mesh(self) -> Mesh:
        made = Ladder(0.1, self.rows).mesh()
        return Mesh(made.reference, made.triangles, node_sets=made.node_sets, source=self)

    def refined(self, density: float) -> Plain:
        return Plain(round(self.rows * density))

    def counts(self) -> dict[str, int]:
        return {"masses": 1, "springs": 2, "elements": 3}

    def with_rows(self, rows: int) -> Plain:
        return Plain(rows)

    @property
    def row_height(self) -> float:
        return 0.1 / self.rows


@validated
class Ballast(Part):
    """A weight that hangs on a cord of its own from each of some nodes of the membrane."""

    kind: ClassVar[str] = "ballast"
    mass: Annotated[Positive, Unit("kg")]
    nodes: str = "start"
    segments: Count = 4
    axial_stiffness: Annotated[Positive, Unit("N")] = 5.0

    def add_nodes(self, builder: Builder, where: str) -> None:
        for node in builder.nodes(self.nodes, where, of_mesh=True).tolist():
            builder.check_room(where, self.segments, self.segments)
            cord = Cord(self.segments, 0.05, self.axial_stiffness, 1e-3, 0.5)
            start = builder.positions[node] - np.array([0.0, 0.0, 0.05])
            builder.add_mass(builder.add_cord(cord, where, start, node)[:1], self.mass)

    def softened(self, factor: float) -> Ballast:
        return replace(self, axial_stiffness=self.axial_stiffness * factor)

    def coarser(self, factor: int) -> tuple[str, Part] | None:
        return (f"{self.segments // factor} segments", replace(self, segments=self.segments // factor))


class Heights(Writer):
    """The lowest point of each sample, in heights.txt; and what was first seen, in its own folder."""

    own_files = ("heights.txt", "heights/*.txt")

    def start(self, sim: Stepper, record: Record) -> None:
        self._record, self._lowest = record, list[float]()

    def sample(self, sim: Stepper) -> None:
        self._lowest.append(float(sim.positions[:, 2].min()))

    def frame(self, sim: Stepper) -> None:
        path, text = self._record.path / "heights" / f"{sim.step_count}.txt", str(sim.time)
        self._record.background.add(lambda: write_text(path, text))

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        write_text(self._record.path / "heights.txt", "\n".join(map(str, self._lowest)))
        self._record.summary["lowest"] = min(self._lowest)


def ladder(cells: int = 4, *parts: Part) -> Scene:
    return Scene(Ladder(0.1, cells).mesh(), RUBBER, [Springs(), Gravity()], [Fixed("start"), *parts])


def files_of(path: Path) -> set[str]:
    return {str(file.relative_to(path)) for file in path.rglob("*") if file.is_file()}


def test_a_pattern(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = ladder()
    assert scene.mesh is not None
    assert [finding.kind for finding in scene.mesh.audit().findings] == ["strain"]
    finer = denser(scene, 2.0)
    assert finer.mesh is not None
    assert finer.mesh.source == Ladder(0.1, 8)
    refused(lambda: denser(scene, 0.3), InputError, "Ladder.cells = 4 would become 1.2")
    assert scene.counts()["masses"] == scene.mesh.node_count
    sim = Simulation(finer)
    sim.step(20)
    assert sim.positions[:, 2].min() < 0.0
    finer.save(tmp_path / "unknown")
    assert (tmp_path / "unknown" / "mesh.npz").is_file()
    monkeypatch.setitem(PATTERNS, "ladder", Ladder)
    finer.save(tmp_path / "known")
    again = Scene.from_toml(tmp_path / "known" / "scene.toml")
    assert again.mesh is not None
    assert again.mesh.source == finer.mesh.source
    coarser = again.with_values({"mesh.cells": 3}).mesh
    assert coarser is not None
    assert coarser.source == Ladder(0.1, 3)


def test_a_pattern_that_derives_from_nothing() -> None:
    scene = replace(ladder(), mesh=Plain(4).mesh())
    assert isinstance(Plain(4), Pattern)
    assert isinstance(Plain(4), RowPattern)
    assert scene.counts()["elements"] == 3
    finer = denser(scene, 2.0).mesh
    assert finer is not None
    assert len(finer.triangles) == 16
    assert kept(scene, jobs_of([4, 8]), "nowhere") == []


def test_a_pattern_that_cannot_be_refined() -> None:
    class Fixed(Pattern):
        def mesh(self) -> Mesh:
            made = Ladder(0.1, 4).mesh()
            return Mesh(made.reference, made.triangles, source=self)

    scene = Scene(Fixed().mesh(), RUBBER, [Springs()])
    refused(lambda: denser(scene, 2.0), InputError, "the pattern Fixed cannot be made coarser or finer")
    assert scene.counts()["elements"] == 8


def test_a_part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refused(lambda: ladder(4, Ballast(mass=0.01)), InputError, r"parts\[1\] = Ballast.*must be one of TipMasses")
    monkeypatch.setitem(PARTS, "ballast", Ballast)
    bare, scene = ladder(), ladder(4, Ballast(mass=0.01))
    assembly = scene.assemble()
    assert assembly.node_count == bare.assemble().node_count + 2 * 4
    assert assembly.extra_masses.sum() == pytest.approx(2 * (0.01 + 0.05 * 1e-3))
    assert {"tether-0", "tether-1-end"} <= assembly.node_sets.keys()
    scene.save(tmp_path)
    assert Scene.from_toml(tmp_path / "scene.toml").parts == scene.parts
    sim = Simulation(scene)
    sim.step(20)
    assert np.abs(sim.forces("tethers")).max() > 0.0
    assert sorted(Subject.of(sim, [sim.positions]).tips) == sorted(assembly.tips)
    names = [variant.name for variant in variants(scene)]
    assert {"part ballast", "1 segments in part ballast"} <= set(names)
    stiff = replace(scene, parts=[scene.parts[0], Ballast(mass=0.01, axial_stiffness=5e6)])
    assert any(saving.part == "ballast" for saving in step_savings(stiff))
    assert idle_laws(scene) == []


def test_an_output(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run"

    def go(*, overwrite: bool = True) -> None:
        Simulation(ladder()).run(0.01, frames=3, samples=5, out=path, pictures=False, overwrite=overwrite)

    go(overwrite=False)
    plain = files_of(path)
    with monkeypatch.context() as patch:
        patch.setattr(run_folder, "WRITERS", [*run_folder.WRITERS, Heights])
        go()
        own = files_of(path) - plain
        assert {"heights.txt", "heights/0.txt"} < own
        assert len(own) == 4
        assert len((path / "heights.txt").read_text().splitlines()) == 5
        assert summary(path)["lowest"] <= 0.0
        (path / "heights" / "mine.csv").write_text("mine")
        patch.setattr(Heights, "start", full)
        with pytest.raises(OutputError, match="no space"):
            go()
    assert files_of(path) == {"heights/mine.csv"}


def test_an_output_that_fails_at_the_end_keeps_no_other_from_its_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def mistaken(*_: Any) -> None:
        raise ValueError("a mistake of the output")

    monkeypatch.setattr(run_folder, "WRITERS", [Heights, *run_folder.WRITERS])
    monkeypatch.setattr(Heights, "finish", mistaken)
    with pytest.raises(ValueError, match="a mistake of the output"):
        Simulation(ladder()).run(0.01, frames=3, samples=5, out=tmp_path / "run", pictures=False)
    assert summary(tmp_path / "run")["outcome"].startswith("failed")
    assert (tmp_path / "run" / "history.csv").is_file()


@pytest.mark.parametrize("files", ["heights.txt", ("../heights.txt",), ("/heights.txt",), (".",)])
def test_an_output_outside_the_folder_is_refused(files: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_folder, "WRITERS", [*run_folder.WRITERS, Heights])
    monkeypatch.setattr(Heights, "own_files", files)
    with pytest.raises(InputError, match=r"Heights\.own_files = .*: must be a tuple"):
        Simulation(ladder()).run(0.01, out=tmp_path / "run", pictures=False, overwrite=True)


def full(*words: Any) -> None:
    """A disk that is full before the first sample."""
    raise OutputError("no space left")
