"""Pages of runs whose files are damaged, or hold what no page can show."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import OutputError, Run
from membrane_rs.report import deployment as module
from membrane_rs.report.curves import LARGEST, curve_section
from membrane_rs.report.deployment import deployment
from membrane_rs.report.energy import energy_section
from membrane_rs.report.facts import audit_section, headline, outcome_banner, readings, scene_section, timing_section
from membrane_rs.report.pictures import sheet_section
from membrane_rs.report.sources import Sources, labelled
from membrane_rs.results.run_history import RunHistory
from report_pages import made, staged_sail


@pytest.fixture(scope="module")
def staged(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return made(staged_sail(), tmp_path_factory.mktemp("runs") / "staged")


class Frames(list[Any]):
    """Frames in a list."""


def with_frames(run: Run, frames: list[Any]) -> Run:
    """The same run with other frames, in memory."""
    return Run(run.scene, run.history, Frames(frames), run.summary)  # type: ignore[arg-type]


def with_history(run: Run, columns: dict[str, Any]) -> Run:
    """The same run with other columns."""
    return Run(run.scene, RunHistory(columns, run.history.units), run.frames, run.summary)


JUNK: tuple[Any, ...] = (
    None,
    3,
    "x",
    [],
    [3],
    {},
    {"x": "y"},
    True,
    [{}],
    [{"name": 3, "start": "x", "end": None}],
    {"error": "x", "nodes": "y"},
)
FREE = (
    "audit", "counts", "curves", "energy_balance", "stages", "versions", "evaluations", "integrator", "dt",
    "limiting_part", "bodies", "stage_starts",
)  # fmt: skip
"""Entries that no reader of summaries checks."""


@pytest.mark.parametrize("junk", JUNK, ids=[str(value)[:20] for value in JUNK])
def test_a_summary_of_junk_is_shown(staged: Run, junk: object) -> None:
    for names in (FREE, FREE[4:5], FREE[:4]):
        summary = {**staged.summary, **dict.fromkeys(names, junk)}
        (one,) = labelled([Run(staged.scene, staged.history, staged.frames, summary, staged.path)])
        for section in (energy_section, headline, audit_section, timing_section, scene_section, readings):
            section(one)


def test_frames_that_no_picture_can_show_are_left_out(staged: Run) -> None:
    good, bad = staged.frames[0], replace(staged.frames[1], positions=np.full_like(staged.frames[1].positions, np.nan))
    shown = deployment(with_frames(staged, [good, bad, staged.frames[2]]))
    assert shown.meta is not None
    assert shown.meta["times"] == [good.time, staged.frames[2].time]
    assert shown.note.startswith("2 of the run's 3 frames. 1 cannot be drawn: their positions are not finite")
    assert "No frame of this run can be drawn" in deployment(with_frames(staged, [bad])).note
    other = replace(good, positions=good.positions[:-1])
    with pytest.raises(OutputError, match=r"frame 1 at 0 s has other nodes or cells than the first one; run the scene"):
        deployment(with_frames(staged, [good, other]))


def test_a_run_of_equal_frames_is_shown(tmp_path: Path, staged: Run) -> None:
    class Still:
        """A run whose shape does not change, and is a point."""

        def __init__(self) -> None:
            self.scene, self.history, self.path = staged.scene, staged.history, None
            frame = staged.frames[0]
            self.frames = [replace(frame, positions=np.zeros_like(frame.positions)), frame]
            self.frames = self.frames[:1]

    shown = deployment(Still())  # type: ignore[arg-type]
    assert shown.meta is not None
    assert shown.meta["times"] == [0.0]
    json.dumps(shown.meta, allow_nan=False)


@pytest.mark.parametrize("far", [np.nan, np.inf, 1e308, -1e200])
def test_a_contact_sheet_has_the_frames_that_can_be_drawn(staged: Run, far: float) -> None:
    good = staged.frames[0]
    bad = replace(good, positions=np.full_like(good.positions, far))
    section = sheet_section(labelled([with_frames(staged, [bad, good])])[0])
    assert section is not None
    assert len(list(section.iter("img"))) == 1
    assert sheet_section(labelled([with_frames(staged, [bad])])[0]) is None


def test_of_very_many_frames_some_are_kept(staged: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_FRAMES", 4)
    shown = deployment(staged)
    assert shown.meta is not None
    assert len(shown.meta["times"]) == 4
    assert (shown.meta["times"][0], shown.meta["times"][-1]) == (0.0, pytest.approx(0.02))
    assert shown.note.startswith(f"4 of the run's {len(staged.frames)} frames. Coordinates")


def test_values_beyond_single_precision_are_missing(staged: Run) -> None:
    first, last = staged.frames[0], staged.frames[-1]
    far = replace(last, on_nodes={**last.on_nodes, "velocity": np.full_like(last.on_nodes["velocity"], 1e308)})
    one, both = (deployment(with_frames(staged, frames)).meta for frames in ([first, last, far], [far, far]))
    assert one is not None
    assert both is not None
    speed = next(field for field in one["fields"] if field["name"] == "speed")
    assert "inf" not in speed["note"]
    assert "speed" not in [field["name"] for field in both["fields"]]


def test_the_scale_of_colours_is_that_of_the_viewer(staged: Run) -> None:
    from membrane_rs.plotting.viewer import Viewer

    viewer = Viewer(staged, color="speed")
    scale = viewer.scale()
    assert scale is not None
    meta = deployment(staged).meta
    assert meta is not None
    ticks = next(field for field in meta["fields"] if field["name"] == "speed")
    factor = 1e3 if "[mm/s]" in ticks["title"] else 1.0
    assert float(ticks["ticks"][0]) == pytest.approx(factor * scale.low, rel=1e-2)
    assert float(ticks["ticks"][-1]) == pytest.approx(factor * scale.high, rel=1e-2)


@pytest.mark.parametrize("far", [1e308, np.inf, np.nan])
def test_a_history_of_values_that_no_axis_holds_is_shown(staged: Run, far: float) -> None:
    count = len(staged.history["time"])
    signs = np.where(np.arange(count) % 2, far, -far)
    columns = {name: values if name in ("time", "stage") else signs for name, values in staged.history.items()}
    one, other = labelled([with_history(staged, columns), with_history(staged, columns)])
    for part in (energy_section, headline, readings):
        part(one)
    for ensemble in (False, True):
        section = curve_section(Sources([one, other], [], ensemble))
        assert "No measure of these runs has changed" in "".join(section.itertext())
    near = np.where(np.arange(count) % 2, 0.5 * LARGEST, staged.history["deployment_rate"])
    some = columns | {"deployment_rate": near}
    for ensemble in (False, True):
        drawn = curve_section(Sources(labelled([with_history(staged, some)] * 2), [], ensemble))
        assert len(list(drawn.iter("svg"))) == 1


def test_a_run_that_goes_on_tells_how_far_it_is(staged: Run) -> None:
    summary = {"outcome": "running", "time": 0.0, "until": 1.0}
    banner = outcome_banner(labelled([Run(staged.scene, staged.history, staged.frames, summary)])[0])
    assert banner is not None
    words = " ".join("".join(banner.itertext()).split())
    assert words.startswith("This run still goes on at 0.02 s of 1 s. A process goes on with it")


def test_single_values_that_no_axis_holds_are_gaps(staged: Run) -> None:
    rates = staged.history["deployment_rate"].copy()
    rates[[3, 4]] = 1e308, -1e308
    runs = labelled([with_history(staged, {**staged.history, "deployment_rate": rates})])
    assert len(list(curve_section(Sources(runs, [])).iter("svg"))) > 1
