"""Sweeps and ensembles: rows, tables, figures, folders, the command line, and what an interrupt leaves."""

from __future__ import annotations

import csv
import inspect
import json
import math
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from child_processes import SECONDS, started, wait_until
from membrane_rs import InputError, MissingFileError, OutputError
from membrane_rs.cli import app
from membrane_rs.study import Sweep, ensemble, open_ensemble, open_sweep, sweep
from membrane_rs.study.common.kept_runs import KeptRuns
from membrane_rs.study.common.one_run import RunResult
from membrane_rs.study.common.rows import table_format
from small_scenes import refused
from typer.testing import CliRunner

SCENE, FREQUENCY, DT = "spinning-tether", "laws.spin.frequency", "run.dt"
SHORT: dict[str, Any] = {"until": 0.01, "samples": 6}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Sweep:
    """Two values from two starts, of which a third has a step that is too long and a fourth is refused."""
    folder = tmp_path_factory.mktemp("sweeps") / "two"
    vary = {FREQUENCY: [1.0, 2.0], DT: ["10us", "0.5ms"]}
    return sweep(SCENE, vary, starts=2, record=["largest_speed"], out=folder, **SHORT)


def test_rows(made: Sweep) -> None:
    assert [(row["run"], row[FREQUENCY], row[DT], row["start"]) for row in made.rows[:3]] == [
        (0, 1.0, 1e-5, 0), (1, 1.0, 1e-5, 1), (2, 1.0, 5e-4, 0)
    ]  # fmt: skip
    assert made.outcomes().keys() <= {"finished", "unstable", "refused"}
    assert [row[DT] for row in made.failures()] == [5e-4] * 4
    first = made.rows[0]
    history = made.history(0)
    assert first["final_largest_speed"] == history["largest_speed"][-1] > 0.0
    assert first["highest_kinetic_energy"] == history["kinetic_energy"].max()
    assert first["energy_error"] == history["energy_error"][-1]
    assert (first["steps"], first["dt"], first["time"]) == (1000, 1e-5, 0.01)
    assert "8 of 8 runs: 4 finished, " in made.summary()
    assert repr(made) == f"Sweep({FREQUENCY}, {DT}: {made.summary().splitlines()[0]})"
    assert f"run 2 ({FREQUENCY} = 1.0, {DT} = 0.0005, start 0) " in made.summary()


def test_the_table_has_all_bits(made: Sweep, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    assert made.path is not None
    read = parquet.read_table(made.path / "table.parquet").to_pylist()
    columns = read[0].keys()
    assert list(columns)[:6] == ["run", FREQUENCY, DT, "start", "outcome", "message"]
    assert read == [{name: row.get(name) for name in columns} for row in made.rows]
    made.save_table(tmp_path / "table.csv")
    with (tmp_path / "table.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [line["message"] for line in lines] == [row["message"] for row in made.rows]
    assert [float(line["final_rate"]) for line in lines[:2]] == [row["final_rate"] for row in made.rows[:2]]
    assert lines[-1]["zero_crossing_time"] == ""
    frame = made.to_pandas()
    assert list(frame.columns) == list(columns)
    assert frame["outcome"].value_counts()["finished"] == 4
    refused(lambda: made.save_table(tmp_path / "table.xls"), InputError, "must be one of parquet, csv")


def test_the_folder_is_read_as_it_was_made(made: Sweep) -> None:
    assert made.path is not None
    found = open_sweep(made.path)
    assert (found.rows, found.points, found.parameters) == (made.rows, made.points, made.parameters)
    assert np.array_equal(found.history(1)["time"], made.history(1)["time"])
    refused(lambda: found.history(8), InputError, "must be from 0 to 7")
    next(made.path.glob("runs/*.npz")).rename(made.path / "runs" / "away")
    assert len(open_sweep(made.path).rows) == 7
    gone = next(k for k in range(8) if k not in {row["run"] for row in open_sweep(made.path).rows})
    refused(lambda: open_sweep(made.path or "").history(gone), InputError, "was not made yet")


@pytest.mark.parametrize(
    "text",
    [
        *("{}", "[]", "{", '{"scene": "", "vary": 3}', '{"scene": "", "vary": {}, "points": 1}'),
        '{"scene": "", "vary": {}, "points": [[]], "starts": 1000000000, "sample": "grid", "record": {}}',
        '{"scene": "", "vary": {}, "points": [[]], "starts": 1, "sample": "lhs", "record": {}}',
    ],
)
def test_damaged_requests(text: str, tmp_path: Path) -> None:
    (tmp_path / "request.json").write_text(text)
    refused(lambda: open_sweep(tmp_path), OutputError, "is no|damaged")
    with pytest.raises(MissingFileError, match=r"no request.json"):
        open_sweep(tmp_path / "none")


def test_figures(made: Sweep, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    grid = made.plot(path=tmp_path / "map.png", title="two")
    assert any("unstable" in text.get_text() or "refused" in text.get_text() for text in grid.axes[0].texts)
    one = sweep(SCENE, {FREQUENCY: [0.2, 1.0, 4.0]}, starts=2, **SHORT)
    figure = one.plot(["final_rate", "highest_hub_torque"], path=tmp_path / "one.pdf", style="paper")
    assert [axes.get_ylabel() for axes in figure.axes] == ["Final rate", "Torque on the hub,\nhighest [mN m]"]
    (line,) = (line for line in figure.axes[0].lines if line.get_linestyle() == "-")
    assert list(line.get_xdata()) == [0.2, 1.0, 4.0]
    means = [np.mean([row["final_rate"] for row in one.rows if row[FREQUENCY] == f]) for f in (0.2, 1.0, 4.0)]
    assert list(line.get_ydata()) == pytest.approx(means, rel=1e-12)
    assert figure.axes[0].get_xscale() == "log"
    vary = {FREQUENCY: "1:2", DT: "5us:500us:log", "run.integrator": "rk4,leapfrog"}
    some = sweep(SCENE, vary, sample="sobol:8", **SHORT)
    scatter = some.plot(path=tmp_path / "samples.svg")
    assert len(scatter.axes) % 3 == 0
    assert all((tmp_path / name).stat().st_size > 1000 for name in ("map.png", "one.pdf", "samples.svg"))
    refused(lambda: one.plot(["final_rat"]), InputError, "did you mean 'final_rate'")
    bad = sweep(SCENE, {DT: [5e-4]}, **SHORT)
    refused(bad.plot, InputError, "no run has come to its end")


def test_an_ensemble(tmp_path: Path) -> None:
    made = ensemble(SCENE, 4, shift=1e-9, out=tmp_path / "starts", table="csv", **SHORT)
    rows = np.stack([made.runs.history(k)["kinetic_energy"] for k in range(4)])
    band = made.band("kinetic_energy")
    assert band.mean == pytest.approx(rows.mean(axis=0), rel=1e-12)
    assert band.high - band.mean == pytest.approx(rows.std(axis=0, ddof=1), rel=1e-6)
    assert np.ptp(rows[:, -1]) > 0.0
    mean, spread = made.statistics()["final_rate"]
    finals = [row["final_rate"] for row in made.runs.rows]
    assert (mean, spread) == pytest.approx((np.mean(finals), np.std(finals, ddof=1)), rel=1e-9)
    curves, picture = made.save(tmp_path / "starts")
    with curves.open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [float(line["kinetic_energy_mean"]) for line in lines] == band.mean.tolist()
    assert float(lines[-1]["kinetic_energy_lowest"]) == rows[:, -1].min()
    assert picture.is_file()
    assert len(made.plot(["hub_torque"]).axes[0].lines) == 1 + 4
    again = open_ensemble(tmp_path / "starts")
    assert repr(again) == "Ensemble(4 of 4 runs: 4 finished)"
    assert again.runs.rows == made.runs.rows
    refused(lambda: made.band("kinetic"), InputError, "did you mean")
    alone = ensemble(SCENE, 1, **SHORT)
    assert math.isnan(alone.statistics()["final_rate"][1])
    assert "mean of 1 start" in [text.get_text() for text in alone.plot().legends[0].get_texts()]


def test_what_an_ensemble_needs(made: Sweep) -> None:
    refused(lambda: open_ensemble(made.path or ""), InputError, "use open_sweep")
    failed = ensemble(SCENE, 1, record={"odd": lambda sim: math.nan}, **SHORT)
    assert failed.runs.outcomes() == {"failed": 1}
    refused(failed.plot, InputError, "no run has come to its end")
    refused(lambda: failed.band("time"), InputError, "no run has come to its end")


def test_one_run_is_no_sweep() -> None:
    refused(lambda: sweep(SCENE, {}), InputError, "vary: names no value, .*such as laws.creases.stiffness, or starts")
    assert sweep(SCENE, {}, starts=2, **SHORT).outcomes() == {"finished": 2}


@pytest.mark.parametrize(("key", "option"), [("run.until", {"until": 1.0}), ("run.samples", {"samples": 5})])
def test_what_an_option_rules_is_not_varied(key: str, option: dict[str, Any]) -> None:
    words = f"vary {key}: {next(iter(option))} = .* rules it in all runs"
    refused(lambda: sweep(SCENE, {key: [2, 3]}, **option), InputError, words)


def test_samples_that_are_rounded_to_one_are_told() -> None:
    found = sweep(SCENE, {"run.substeps": "1:3"}, sample="lhs:9", until=1e-3, samples=2)
    assert found.summary() == "3 of 3 runs: 3 finished (9 samples, of which 3 are different)"
    found = sweep(SCENE, {FREQUENCY: "1:3"}, sample="lhs:3", starts=2, until=1e-3, samples=2)
    assert found.summary() == "6 of 6 runs: 6 finished"


def test_a_keyword_that_does_not_exist() -> None:
    wrong: Any = {"untill": 3}
    with pytest.raises(TypeError, match=r"^sweep\(\): got an unexpected keyword argument 'untill'$"):
        sweep(SCENE, {FREQUENCY: [1]}, **wrong)
    with pytest.raises(TypeError, match=r"^ensemble\(\): got an unexpected keyword argument 'untill'$"):
        ensemble(SCENE, 2, **wrong)


def test_signatures_name_all_options() -> None:
    of_sweep, of_ensemble = inspect.signature(sweep).parameters, inspect.signature(ensemble).parameters
    assert {"until", "samples", "record", "time_limit", "executor", "jobs", "out", "overwrite", "retry"} < set(of_sweep)
    assert set(of_sweep) - set(of_ensemble) == {"vary", "sample", "seed"}
    assert (of_sweep["shift"].default, of_sweep["executor"].default) == (1e-12, "threads")


def test_results_make_their_folder(made: Sweep, tmp_path: Path) -> None:
    few = ensemble(SCENE, 2, **SHORT)
    assert all(path.is_file() for path in few.save(tmp_path / "a" / "b"))
    for write in (few.plot, made.plot):
        refused(lambda write=write: write(path=tmp_path / "c" / "d.png"), OutputError, "cannot write .*d.png: No such")  # type: ignore[misc]
    refused(lambda: made.save_table(tmp_path / "c" / "d.csv"), OutputError, "cannot write .*d.csv: No such")
    assert not (tmp_path / "c").exists()


def test_the_format_of_a_table(monkeypatch: pytest.MonkeyPatch) -> None:
    refused(lambda: table_format("xlsx"), InputError, "must be one of parquet, csv")
    assert table_format("csv") == "csv"
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert table_format(None) == "csv"
    with pytest.raises(ImportError, match=r"membrane_rs\[sweep\]"):
        table_format("parquet")


WORDS = ["--until", "1ms", "--samples", "3", "--jobs", "1"]


def run(*words: str) -> Any:
    return CliRunner().invoke(app, list(words))


@pytest.fixture
def in_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs of commands in threads: a process needs seconds to start, and the system may end it for want of memory."""
    monkeypatch.setattr("membrane_rs.cli.many_runs.HERE", "threads")


@pytest.mark.usefixtures("in_threads")
def test_the_commands(tmp_path: Path) -> None:
    out = str(tmp_path / "out")
    words = ["sweep", SCENE, "--vary", f"{FREQUENCY}=60rpm,2", "--set", "run.dt=20us", *WORDS, "--out", out]
    first = run(*words, "--json", "--table", "csv", "--record", "largest_speed")
    assert first.exit_code == 0, first.output
    document = json.loads(first.stdout)
    assert document["outcomes"] == {"finished": 2}
    assert [(row[FREQUENCY], row["dt"]) for row in document["runs"]] == [(1.0, 2e-5), (2.0, 2e-5)]
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"table.csv", "sweep.png", "scene.toml", "runs"}
    changed = run(*words, "--table", "csv")
    assert (changed.exit_code, "record.largest_speed = 'm/s' there" in changed.output) == (1, True), changed.output
    failed = run("sweep", SCENE, "--vary", f"{DT}=0.4", "--until", "1", "--jobs", "1", "--out", str(tmp_path / "bad"))
    assert failed.exit_code == 1
    assert "1 of 1 runs: 1 refused" in failed.output
    assert "No figure: no run has come to its end" in failed.output
    starts = run("ensemble", SCENE, "--starts", "2", *WORDS, "--out", str(tmp_path / "starts"), "--plot", "hub_torque")
    assert starts.exit_code == 0, starts.output
    assert "standard deviation" in starts.output
    assert (tmp_path / "starts" / "ensemble.png").is_file()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "nothing is varied"),
        (["--vary", FREQUENCY], "must be KEY=VALUES"),
        (["--vary", f"{FREQUENCY}=1", "--vary", f"{FREQUENCY}=2"], "is given twice"),
        (["--vary", f"{FREQUENCY}=1,2 kg"], "is a mass"),
        (["--vary", f"{FREQUENCY}=1:2:1000", "--starts", "1000"], "1,000,000 runs"),
        (["--vary", f"{FREQUENCY}=1", "--starts", "0"], "starts = 0"),
        (["--vary", f"{FREQUENCY}=1", "--until", "-1"], "until = -1.0"),
        (["--vary", f"{FREQUENCY}=1", "--time-limit", "0"], "time_limit = 0.0"),
        (["--vary", f"{FREQUENCY}=1", "--record", "speed"], "is no known measure"),
        (["--vary", f"{FREQUENCY}=1", "--table", "xml"], "must be one of parquet, csv"),
        (["--vary", f"{FREQUENCY}=1", "--jobs", "0"], "jobs = 0"),
        (["--vary", f"{FREQUENCY}=1:2", "--sample", "sobol:3"], "take 2 or 4"),
    ],
)
def test_wrong_words_are_refused_before_a_run(words: list[str], message: str, tmp_path: Path) -> None:
    made = run("sweep", SCENE, *words, "--out", str(tmp_path / "out"))
    assert made.exit_code == 2, made.output
    assert message in " ".join(made.output.split())
    assert not (tmp_path / "out").exists()


def test_the_table_has_all_runs_that_an_interrupt_leaves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also one that is on the disk, of which the sweep has not heard."""
    keep = KeptRuns.keep

    def keep_and_stop(self: KeptRuns, result: RunResult) -> None:
        keep(self, result)
        if result.point.values[FREQUENCY] == 2.0:
            raise KeyboardInterrupt

    monkeypatch.setattr(KeptRuns, "keep", keep_and_stop)
    with pytest.raises(KeyboardInterrupt):
        sweep(SCENE, {FREQUENCY: [1, 2, 3]}, jobs=1, out=tmp_path, table="csv", **SHORT)
    assert [line.split(",")[:2] for line in (tmp_path / "table.csv").read_text().splitlines()[1:]] == [
        ["0", "1.0"], ["1", "2.0"]
    ]  # fmt: skip


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_an_interrupted_sweep_goes_on(number: signal.Signals, tmp_path: Path) -> None:
    """Of the whole group, as a terminal does; SIGKILL of the command alone, whose processes end with it."""
    words = ["sweep", SCENE, "--vary", f"{FREQUENCY}=1,1.5,2", "--out", "out"]
    words += ["--until", "1", "--samples", "3", "--jobs", "2"]
    # The second run is not kept before the signal comes, however late that is.
    held = "import sys, time; from membrane_rs.study.common.kept_runs import KeptRuns; keep, kept = KeptRuns.keep, []\n"
    held += "KeptRuns.keep = lambda *words: time.sleep(1e6) if kept else kept.append(keep(*words))\n"
    held += "sys.argv[0] = 'membrane-rs'; from membrane_rs.cli import main; main()"
    folder, here = tmp_path / "out" / "runs", {"cwd": tmp_path, "start_new_session": True}
    with started([sys.executable, "-c", held, *words], stderr=subprocess.PIPE, text=True, **here) as process:
        assert process.stderr is not None
        assert process.stderr.readline().startswith("[1/3] ")
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        pids = children.read_text().split() if children.is_file() else []
        kept = {path.name: path.read_bytes() for path in folder.glob("*.npz")}
        if number == signal.SIGKILL:
            process.kill()
        else:
            os.killpg(process.pid, number)
        _, said = process.communicate(timeout=SECONDS)
    assert len(kept) == 1
    if number == signal.SIGINT:
        assert process.returncode == 130
        assert "the same command goes on with them" in said
        assert (tmp_path / "out" / "table.parquet").is_file() or (tmp_path / "out" / "table.csv").is_file()
    wait_until(lambda: not any(Path(f"/proc/{pid}").exists() for pid in pids), "the processes have ended")
    again = [sys.executable, "-m", "membrane_rs", *words]
    subprocess.run(again, cwd=tmp_path, check=True, capture_output=True, timeout=SECONDS)
    assert len(list(folder.glob("*.npz"))) == 3
    assert all((folder / name).read_bytes() == content for name, content in kept.items())


def test_a_law_that_is_varied_is_true_or_false_in_csv(tmp_path: Path) -> None:
    vary = {"laws.mass_damping": [True, False]}
    sweep("single-crease", vary, until=1e-4, samples=2, out=tmp_path / "out", table="csv")
    with (tmp_path / "out" / "table.csv").open(newline="") as file:
        assert [line["laws.mass_damping"] for line in csv.DictReader(file)] == ["true", "false"]
