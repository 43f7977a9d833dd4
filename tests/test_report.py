"""The text of a page of runs: what it says of runs of every kind, and what is refused."""

from __future__ import annotations

import json
import os
import re
import shutil
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import membrane_rs
import pytest
from membrane_rs import InputError, InputTypeError, MissingFileError, OutputError, Run, Scene, UnstableError, open_run
from membrane_rs.plotting.energy import RESIDUAL, term_changes
from membrane_rs.plotting.stage_records import stage_records
from membrane_rs.report import pictures as report_pictures
from membrane_rs.report import write_report
from membrane_rs.report.curves import curve_section, shown_columns
from membrane_rs.report.energy import energy_section
from membrane_rs.report.facts import audit_section, headline, outcome_banner, readings, scene_section, timing_section
from membrane_rs.report.markup import prose
from membrane_rs.report.sources import Sources, labelled
from membrane_rs.results.experiment import Experiment
from membrane_rs.results.experiment_file import read_experiment
from report_pages import made, sail, staged_sail
from small_scenes import refused
from staged_scenes import oscillator, started
from test_cli import call


@pytest.fixture(scope="module")
def staged(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return made(staged_sail(), tmp_path_factory.mktemp("runs") / "staged")


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw no contact sheets, which takes seconds."""
    monkeypatch.setattr(report_pictures, "_drawn", lambda _: [])


def text_of(part: Element | None) -> str:
    """The words of a part of the page."""
    assert part is not None
    return " ".join(" ".join(part.itertext()).split())


def cells(part: Element) -> list[list[str]]:
    """The rows of its first table."""
    (rows, *_) = part.iter("table")
    return [["".join(cell.itertext()) for cell in row] for row in rows.iter("tr")]


def sources(*runs: Run, experiments: list[Experiment] | None = None, ensemble: bool = False) -> Sources:
    return Sources(labelled(runs), experiments or [], ensemble)


def test_the_energy_table_is_the_balance_of_each_stage(staged: Run) -> None:
    (one,) = labelled([staged])
    head, *rows = cells(energy_section(one))
    assert head[1:] == ["hold </script>", "let go", "whole run"]
    records = stage_records(staged.stages)
    unit = {"J": 1.0, "mJ": 1e-3, "µJ": 1e-6}[head[0].split("[")[1].rstrip("]")]
    table = {name: values for name, *values in rows}
    for k in range(2):
        terms = term_changes(staged.history, records, k)
        assert float(table["kinetic energy"][k]) == pytest.approx(terms["kinetic_energy"] / unit, abs=1e-4)
        assert float(table["work of spring damping"][k]) == pytest.approx(terms["work_spring_damping"] / unit, abs=1e-4)
        assert float(table["residual"][k]) == pytest.approx(terms[RESIDUAL] / unit, abs=1e-4)
    change = staged.history["kinetic_energy"][-1] - staged.history["kinetic_energy"][0]
    assert float(table["kinetic energy"][2]) == pytest.approx(change / unit, abs=1e-4)


def test_numbers_of_a_finished_run(staged: Run) -> None:
    (one,) = labelled([staged])
    assert outcome_banner(one) is None
    words = text_of(headline(one))
    assert f"Final deployment rate {staged.history['deployment_rate'][-1]:.4f}" in words
    assert f"{staged.summary['counts']['nodes']:,} nodes" in words
    timings = text_of(timing_section(one))
    assert f"Steps {staged.summary['steps']:,}" in timings
    assert f"Evaluations of the forces {staged.summary['evaluations']:,}" in timings
    assert "let go 0.01 0.02 duration" in timings
    scene = scene_section(one)
    assert Scene.from_toml(_saved(scene)).name == staged.scene.name
    assert f"membrane_rs {membrane_rs.__version__}" in text_of(scene)
    values = {row[0]: row[1] for row in cells(_whole(readings(one)))}
    assert values["Deployment rate"] == f"{staged.history['deployment_rate'][-1]:.4g}"
    assert values["Torque on the hub [µN m]"] == f"{1e6 * staged.history['hub_torque'][-1]:.4g}"


def _saved(scene: Element) -> Path:
    import tempfile

    path = Path(tempfile.mkdtemp()) / "again.toml"
    path.write_text("".join(next(scene.iter("code")).itertext()), encoding="utf-8")
    return path


def _whole(part: Element | None) -> Element:
    from membrane_rs.report.markup import element

    assert part is not None
    return element("div", part)


def test_findings_of_the_audit_stand_with_errors_first(staged: Run) -> None:
    entries = [
        {"severity": kind, "kind": "step", "count": 1, "message": f"a {kind} <b>", "remedy": f"mend the `{kind}`"}
        for kind in ("info", "warning", "error")
    ]
    staged.summary["audit"], before = [*entries, "no finding"], staged.summary["audit"]
    try:
        section = audit_section(labelled([staged])[0])
    finally:
        staged.summary["audit"] = before
    assert [item.get("class") for item in section.iter("li")] == ["error", "warning", "info"]
    assert text_of(section).startswith("Audit Error a error <b> mend the error Warning")
    assert [code.text for code in section.iter("code")] == ["error", "warning", "info"]
    assert prose("a ` alone") == ["a ` alone"]


def test_a_run_that_stopped_itself_shows_its_cause_first(tmp_path: Path) -> None:
    with pytest.raises(UnstableError) as caught:
        membrane_rs.run(sail(), 0.02, dt=2e-4, frames=5, out=tmp_path / "run", pictures=False)
    run = open_run(tmp_path / "run")
    (one,) = labelled([run])
    assert text_of(outcome_banner(one)).startswith("This run stopped itself at ")
    assert str(caught.value)[:40] in text_of(outcome_banner(one))
    page = write_report(run, tmp_path / "page.html").read_text("utf-8")
    assert page.index("This run stopped itself") < page.index('id="deployment"')


@pytest.mark.parametrize("outcome", ["running", "killed", "interrupted", "failed: OutputError: no space"])
def test_a_run_that_has_not_ended_as_planned_is_shown(tmp_path: Path, staged: Run, outcome: str) -> None:
    assert staged.path is not None
    folder = shutil.copytree(staged.path, tmp_path / "run")
    summary = json.loads((folder / "summary.json").read_text())
    for key in ("curves", "energy_balance", "stages", "evaluations", "frames", "samples", "time", "wall_time", "steps"):
        summary.pop(key)
    (folder / "summary.json").write_text(json.dumps(summary | {"outcome": outcome}))
    history = (folder / "history.csv").read_text().splitlines(keepends=True)
    (folder / "history.csv").write_text("".join(history[: len(history) // 2]) + "0.0")
    page = write_report(folder, tmp_path / "page.html").read_text("utf-8")
    word = "killed" if outcome == "running" else outcome.partition(":")[0]
    assert re.search(rf"This run (was|is)? ?{word}", page)
    assert ("no space" in page) == outcome.startswith("failed")


def test_a_killed_run_shows_how_far_it_has_come_and_no_costs_of_its_start(tmp_path: Path, staged: Run) -> None:
    assert staged.path is not None
    folder = shutil.copytree(staged.path, tmp_path / "run")
    summary = json.loads((folder / "summary.json").read_text())
    (folder / "summary.json").write_text(
        json.dumps(summary | {"outcome": "running", "time": 0.0, "wall_time": 0.125, "steps": 0, "stages": []})
    )
    (one,) = labelled([open_run(folder)])
    end = one.run.history["time"][-1]
    assert end > 0.0
    assert f"Simulated {end:.6g} s" in text_of(headline(one))
    assert text_of(outcome_banner(one)).startswith(f"This run was killed at {end:.6g} s")
    for words in ("0.125 s", "Steps", "Wall time"):
        assert words not in text_of(headline(one)) + text_of(timing_section(one))


@pytest.mark.parametrize("samples", [0, 1])
def test_a_run_with_hardly_a_sample_is_shown(tmp_path: Path, staged: Run, samples: int) -> None:
    assert staged.path is not None
    folder = shutil.copytree(staged.path, tmp_path / "run")
    history = (folder / "history.csv").read_text().splitlines(keepends=True)
    (folder / "history.csv").write_text("".join(history[: 1 + samples]))
    (folder / "frames.pvd").unlink()
    page = write_report(folder, tmp_path / "page.html").read_text("utf-8")
    assert "This run has no frames" in page
    assert "too few samples for a balance" in page
    assert "k3d-source" not in page.split("<script")[1]


def test_a_folder_of_an_earlier_version_is_shown(tmp_path: Path, staged: Run) -> None:
    assert staged.path is not None
    folder = shutil.copytree(staged.path, tmp_path / "run")
    lines = [line.split(",") for line in (folder / "history.csv").read_text().splitlines()]
    lines[0][lines[0].index("reference_energy")] = "energy_turned_over"
    kept = [k for k, name in enumerate(lines[0]) if name not in ("motor_work", "largest_film_stress", "hub_torque")]
    (folder / "history.csv").write_text("".join(",".join(line[k] for k in kept) + "\n" for line in lines))
    summary = json.loads((folder / "summary.json").read_text())
    for stage in summary["stages"]:
        del stage["motor_work"]
    del summary["audit"], summary["request"], summary["versions"]
    (folder / "summary.json").write_text(json.dumps(summary))
    page = write_report(folder, tmp_path / "page.html").read_text("utf-8")
    assert "hold &lt;/script&gt;" in page
    assert "Torque on the hub" not in page


def test_a_scene_without_film_and_one_without_spin(tmp_path: Path) -> None:
    made(oscillator(), tmp_path / "cord", until=0.05)
    page = write_report([tmp_path / "cord"], tmp_path / "page.html").read_text("utf-8")
    meta = json.loads(re.search(r'id="deployments">(.*?)</script>', page)[1])["runs"][0]["meta"]  # type: ignore[index]
    assert (meta["triangle_count"], meta["line_count"], meta["turns"]) == (0, 1, False)
    assert [field["name"] for field in meta["fields"]] == ["spring_strain", "buckled", "tension", "speed"]
    assert "Phase difference" not in page


def test_a_run_in_memory_is_shown(tmp_path: Path) -> None:
    run = membrane_rs.run(sail(), 0.004, frames=3, record={"spread": (lambda sim: sim.positions.max(), "m")})
    page = write_report(run, tmp_path / "page.html").read_text("utf-8")
    assert "Spread [mm]" in page
    assert "<title>small-sail</title>" in page


def test_columns_of_rounding_have_no_panel(staged: Run) -> None:
    shown = shown_columns(sources(staged))
    assert shown[0] == "deployment_rate"
    assert not {"time", "stage", "hub_angle", "kinetic_energy", "energy_error", "work_spin", "motor_work"} & set(shown)
    still = started(oscillator())
    still.run(0.01)
    assert shown_columns(sources(staged)) == shown


def test_experiments_and_ensembles_are_laid_over(tmp_path: Path, staged: Run) -> None:
    data = tmp_path / "camera.csv"
    data.write_text(
        "time [ms],deployment_rate,motor_work [mJ],colour\n0,0.5,1,1\n5,0.6,2,1\n20,,3,1\n", encoding="utf-8"
    )
    measured = read_experiment(data, staged.history.units)
    section = curve_section(sources(staged, staged, experiments=[measured]))
    words = text_of(section)
    assert "camera" in words
    assert "Measured columns that no run has: camera: colour." in words
    assert "Work of the motor" in words  # measured, so it has a panel
    classes = [part.get("class") for part in section.iter() if part.get("class")]
    assert classes.count("data-0") == 2
    assert {"run-0", "run-1"} <= set(classes)
    assert "staged (1)" in words
    ensemble = curve_section(sources(staged, staged, ensemble=True))
    classes = [part.get("class") for part in ensemble.iter() if part.get("class")]
    assert classes.count("mean") == 2 * len(shown_columns(sources(staged)))
    assert classes.count("each") == 2 * len(shown_columns(sources(staged)))
    assert "mean of 2 runs, with one standard deviation to each side" in text_of(ensemble)


def test_a_page_is_the_same_file_again(tmp_path: Path, staged: Run) -> None:
    pages = [write_report(staged, tmp_path / f"{k}.html").read_bytes() for k in range(2)]
    assert pages[0] == pages[1]


def test_a_figure_marks_its_times(staged: Run) -> None:
    (svg, *_) = curve_section(sources(staged)).iter("svg")
    left, right, first, last, top, bottom = map(float, str(svg.get("data-time-scale")).split())
    _, _, width, height = map(float, str(svg.get("viewBox")).split())
    assert 0.0 < left < right < width
    assert 0.0 < top < bottom < height
    assert (first, last) == pytest.approx((0.0, 0.02))
    assert str(svg.get("aria-label")).startswith("Deployment rate against time; staged: from ")


REFUSED: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"runs": []}, InputError, "runs: none is given"),
    ({"runs": 3}, InputTypeError, "3: must be one, or a list of several"),
    ({"runs": [3]}, InputTypeError, r"runs\[0\] = 3: must be a run, or the folder of one"),
    ({"runs": ["none"]}, MissingFileError, "no summary at none"),
    ({"ensemble": True}, InputError, "ensemble: one run has no spread; give several runs"),
    ({"title": 3}, InputTypeError, "title = 3: must be a text"),
    ({"data": "none.csv"}, MissingFileError, r"no measured curves at none\.csv"),
    ({"data": 3}, InputTypeError, "must be one, or a list"),
    ({"path": "there.html"}, OutputError, r"there\.html is there already; .*--overwrite"),
    ({"path": "none/page.html"}, OutputError, r"cannot write none/page\.html: there is no folder none; make it"),
    ({"path": "page.pdf"}, InputError, r"page\.pdf: a page is HTML, and this name says application/pdf; .* \.html"),
    ({"path": "."}, OutputError, r"cannot write \.: it is a folder; name a file in it, such as report\.html"),
    ({"path": os.devnull, "overwrite": True}, OutputError, "no regular file"),
]


@pytest.mark.parametrize("case", REFUSED, ids=[words for _, _, words in REFUSED])
def test_what_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, staged: Run, case: Any) -> None:
    changes, kind, words = case
    monkeypatch.chdir(tmp_path)
    Path("there.html").write_text("mine")
    with pytest.raises(kind, match=words):
        write_report(**{"runs": staged, "path": "page.html", **changes})
    assert Path("there.html").read_text() == "mine"
    assert not Path("page.html").exists()


def test_an_ensemble_is_of_one_scene(tmp_path: Path, staged: Run) -> None:
    other = made(sail(name="other"), tmp_path / "other", frames=())
    with pytest.raises(InputError, match=r"runs\[1\] is of the scene 'other', runs\[0\] of 'small-sail'; give"):
        write_report([staged, other], tmp_path / "page.html", ensemble=True)


def test_a_table_in_place_of_a_run_is_refused(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    refused(lambda: write_report([tmp_path / "d.csv"], page), InputError, r"given as data \(data=, --data\)")


@pytest.mark.parametrize(
    ("name", "hint"), [("colour", "known are: .*deployment_rate, "), ("hub_trque", r"did you mean 'hub_torque'\?")]
)
def test_data_of_other_measures_are_refused(tmp_path: Path, staged: Run, name: str, hint: str) -> None:
    data = tmp_path / "other.csv"
    data.write_text(f"time,{name}\n0,1\n", encoding="utf-8")
    why = f"data other: its columns, {name}, are none of the runs; {hint}"
    with pytest.raises(InputError, match=why):
        write_report(staged, tmp_path / "page.html", data=data)


def test_many_runs_share_the_bytes_of_a_page(tmp_path: Path, staged: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    from membrane_rs.report import deployment

    frame = staged.frames[0]
    monkeypatch.setattr(deployment, "MOST_BYTES", 2 * 5 * deployment._frame_bytes(frame, []))
    shown = [deployment.deployment(staged, share) for share in (1.0, 0.5, 0.1)]
    first, second, third = shown
    assert first.meta is not None
    assert second.meta is not None
    assert len(first.meta["times"]) == len(staged.frames)
    assert len(second.meta["times"]) == 5 < len(staged.frames)
    assert second.meta["fields"] == []
    assert second.note.startswith(f"5 of the run's {len(staged.frames)} frames.")
    assert (second.meta["times"][0], second.meta["times"][-1]) == (0.0, pytest.approx(0.02))
    assert (third.meta, third.data) == (None, "")
    assert "too large for this page" in third.note


def test_the_command_makes_a_page(tmp_path: Path, staged: Run) -> None:
    page = tmp_path / "page.html"
    code, shown = call("report", staged.path, staged.path, "--out", page, "--ensemble", "--title", "Two")
    assert (code, str(page) in shown.replace("\n", "")) == (0, True)
    assert "<title>Two</title>" in page.read_text("utf-8")
    code, shown = call("report", staged.path, "--out", page)
    assert (code, "is there already" in shown) == (1, True)
    assert call("report", staged.path, "--out", page, "--overwrite")[0] == 0
    assert call("report", tmp_path / "none", "--out", tmp_path / "other.html")[0] == 2
    assert call("report")[0] == 2
