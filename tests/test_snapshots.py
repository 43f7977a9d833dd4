"""Pictures: not blank, the same camera, turned as the hub turned, and all that a run promises."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_simulation import FakeSimulation, small_sail, turned_flat
from membrane_rs.plotting.animation import MOST_FRAMES, chosen
from membrane_rs.plotting.matplotlib import MatplotlibPainter
from membrane_rs.plotting.painter import Painter, ProcessPainter, forget_probe, pyvista_works
from membrane_rs.plotting.picture import Subject
from membrane_rs.plotting.sheets import captions_of, contact_sheet
from membrane_rs.plotting.snapshots import SnapshotTaker
from membrane_rs.runs import RunFolder
from membrane_rs.scene import Scene
from membrane_rs.scene.parts import Tether, Tethers, TipMasses
from PIL import Image

PAINTERS = [MatplotlibPainter, *([ProcessPainter] if pyvista_works() else [])]


def sail() -> tuple[Any, Subject]:
    sim: Any = FakeSimulation()
    return sim, Subject.of(sim, [sim.positions])


def ink(image: np.ndarray[Any, Any]) -> float:
    """Share of the picture that is not white."""
    return float((image.min(axis=2) < 250).mean())


@pytest.mark.parametrize("painter", PAINTERS)
def test_flat_sail_covers_more_than_the_stowed_one(painter: type[Any]) -> None:
    sim, subject = sail()
    artist: Painter = painter(subject, 200)
    stowed, flat = artist.paint(sim.positions), artist.paint(sim.assembly.reference)
    again = artist.paint(sim.positions)
    artist.close()
    assert stowed.shape == (200, 200, 3)
    assert stowed.dtype == np.uint8
    assert 0.01 < ink(stowed) < ink(flat) < 0.9
    assert ink(flat[:3]) == ink(flat[-3:]) == 0.0
    assert np.array_equal(stowed, again)


@pytest.mark.parametrize("painter", PAINTERS)
def test_fixed_camera_sees_the_hub_turn(painter: type[Any]) -> None:
    sim, subject = sail()
    artist: Painter = painter(Subject(**{**vars(subject), "spool": None}), 200)
    reference = sim.assembly.reference
    turned = artist.paint(reference, math.radians(30.0))
    expected = artist.paint(turned_flat(sim.assembly, 30.0))
    unturned = artist.paint(reference)
    artist.close()
    assert (np.abs(turned.astype(int) - expected) > 8).mean() < 0.01
    assert (np.abs(turned.astype(int) - unturned) > 8).mean() > 0.05


@pytest.mark.parametrize("painter", PAINTERS)
def test_the_two_faces_differ(painter: type[Any]) -> None:
    sim, subject = sail()
    artist: Painter = painter(subject, 200)
    front = artist.paint(sim.assembly.reference)
    back = artist.paint(sim.assembly.reference * [1.0, -1.0, 1.0])
    artist.close()
    assert (np.abs(front.astype(int) - back[:, ::-1]) > 8).mean() > 0.1


def test_what_is_drawn() -> None:
    sim, subject = sail()
    assert sorted(subject.tips) == sorted(sim.assembly.node_sets["corners"])
    assert len(subject.cords) == 4 * 3
    assert subject.spool is not None
    assert subject.spool[0] == 0.025
    assert subject.reach >= 0.2 / math.sqrt(2.0)
    assert set(subject.petals.tolist()) == {0, 1, 2, 3}


def test_tip_mass_of_a_tether_among_others() -> None:
    sail_scene = small_sail()
    tether = Tether(
        start=(0.3, 0.0, 0.0),
        end=(0.4, 0.0, 0.0),
        segments=2,
        axial_stiffness=1.0,
        linear_density=1e-4,
        tip_mass=1e-3,
    )
    scene = Scene(sail_scene.mesh, sail_scene.material, [], [Tethers(segments=3), tether, TipMasses(1e-3, [0])])
    sim: Any = FakeSimulation(scene)
    subject = Subject.of(sim, [sim.positions])
    ends = [tuple(point) for point in sim.assembly.reference[subject.tips]]
    assert ends == [(0.4, 0.0, 0.0), tuple(sim.assembly.reference[0])]


def test_snapshots_are_taken_at_or_after_their_time() -> None:
    sim: Any = FakeSimulation()
    taker = SnapshotTaker([0.0, 0.05, 0.0502, 0.1, 0.9], 0.0)
    for time in np.linspace(0.0, 0.2, 201):
        sim.show(float(time), sim.positions)
        taker.offer(sim)
    assert [round(shot.time, 9) for shot in taker.taken] == [0.0, 0.05, 0.051, 0.1]


def test_snapshots_of_a_restored_run_begin_where_it_does() -> None:
    sim: Any = FakeSimulation()
    taker = SnapshotTaker([0.0, 0.05, 0.1], 0.07)
    for time in (0.07, 0.1):
        sim.show(time, sim.positions)
        taker.offer(sim)
    assert [shot.time for shot in taker.taken] == [0.1]


def test_captions_have_letters_and_seconds() -> None:
    """All of a sheet have the decimals that one of them needs."""
    assert captions_of([0.0, 0.05, 0.1, 0.2]) == ["(a) 0.00 s", "(b) 0.05 s", "(c) 0.10 s", "(d) 0.20 s"]
    assert captions_of([0.0, 1.0]) == ["(a) 0.0 s", "(b) 1.0 s"]
    assert captions_of([0.0, 1.0, 1.0, 1.0005])[2:] == ["(c) 1.0000 s", "(d) 1.0005 s"]
    assert captions_of([k / 3 for k in range(3)]) == ["(a) 0.000 s", "(b) 0.333 s", "(c) 0.667 s"]
    assert captions_of([]) == []


def test_contact_sheet_has_rows_of_five() -> None:
    images = [np.full((70, 70, 3), 40 * (k + 1) % 255, dtype=np.uint8) for k in range(7)]
    sheet = contact_sheet(images, [str(k) for k in range(7)], "title")
    one = contact_sheet(images[:1], ["a"], "title")
    assert sheet.shape[1] == 5 * one.shape[1]
    rows = [contact_sheet(images[:n], [""] * n, "").shape[0] for n in (1, 6, 7)]
    assert rows[0] < rows[1] == rows[2]


def test_animation_shows_first_and_last_and_not_too_many() -> None:
    frames = [(0.1 * k, Path(f"{k}.vtu")) for k in range(1000)]
    assert chosen(frames[:81]) == frames[:81]
    assert len(chosen(frames)) == MOST_FRAMES
    assert chosen(frames)[0] == frames[0]
    assert chosen(frames)[-1] == frames[-1]
    assert chosen([]) == []


def test_pictures_of_a_run(tmp_path: Path) -> None:
    told: list[tuple[str, int, int]] = []
    folder = RunFolder(tmp_path / "run", progress=lambda *what: told.append(what))
    sim: Any = FakeSimulation(small_sail(snapshots=[0.0, 0.1]))
    folder.start(sim)
    for time, shape in ((0.0, sim.assembly.positions), (0.1, sim.assembly.reference)):
        sim.show(time, shape)
        folder.sample(sim)
        folder.frame(sim)
    folder.finish(sim, None)
    names = {file.name for file in (tmp_path / "run" / "snapshots").iterdir()}
    assert names == {f"{view}{end}.png" for view in ("turning", "fixed") for end in ("", "-0.000s", "-0.100s")}
    assert told == [("pictures", k, 6) for k in range(1, 7)]
    with Image.open(tmp_path / "run" / "animation.gif") as gif:
        assert (gif.size, getattr(gif, "n_frames", 1)) == ((480, 480), 2)
    with Image.open(tmp_path / "run" / "snapshots" / "fixed-0.100s.png") as picture:
        assert picture.size == (700, 700)


def test_without_graphics_matplotlib_draws(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("membrane_rs.plotting.process.COMMAND", [sys.executable, "-c", ""])
    forget_probe()
    try:
        folder = RunFolder(tmp_path / "run")
        sim: Any = FakeSimulation(small_sail(snapshots=[0.0]))
        folder.start(sim)
        folder.sample(sim)
        folder.finish(sim, None)
    finally:
        forget_probe()
    assert '"pictures": "matplotlib"' in (tmp_path / "run" / "summary.json").read_text()
    assert (tmp_path / "run" / "snapshots" / "turning-0.000s.png").is_file()
