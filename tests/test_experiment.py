"""Measured curves from CSV files: what is read, and what is refused with its line and a remedy."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest
from membrane_rs import InputError, MissingFileError
from membrane_rs.results import experiment_file
from membrane_rs.results.experiment_file import read_experiment


def table(folder: Path, content: str | bytes) -> Path:
    path = folder / "spin test.csv"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def test_columns_with_and_without_units(tmp_path: Path) -> None:
    text = (
        "\ufeff# by hand\ntime [ms] , deployment_rate,hub_torque [mN m]\n\n0,0.25, nan\n# a pause\n10,,2\n20,0.5,-4e0"
    )
    measured = read_experiment(table(tmp_path, text), {"hub_torque": "N m", "deployment_rate": "", "time": "s"})
    assert measured.name == "spin test"
    assert measured.time == pytest.approx([0.0, 0.01, 0.02])
    assert list(measured.columns) == ["deployment_rate", "hub_torque"]
    assert dict(measured.units) == {"deployment_rate": "", "hub_torque": "N m"}
    assert measured.columns["hub_torque"] == pytest.approx([np.nan, 0.002, -0.004], nan_ok=True)
    time, rate = measured.curve("deployment_rate")
    assert time == pytest.approx([0.0, 0.02])
    assert rate == pytest.approx([0.25, 0.5])
    with pytest.raises(InputError, match=r"column 'rate': spin test has none; it has deployment_rate, hub_torque"):
        measured.curve("rate")


@pytest.mark.parametrize("mark", [",", ";", "\t"])
def test_marks_between_cells(tmp_path: Path, mark: str) -> None:
    path = table(tmp_path, mark.join(["time", "speed [km/h]"]) + f"\r\n1{mark}36\r\n2{mark}72\r\n")
    assert read_experiment(path).columns["speed"].tolist() == [36.0, 72.0]
    assert read_experiment(path).units["speed"] == "km/h"
    assert read_experiment(path, {"speed": "m/s"}).columns["speed"] == pytest.approx([10.0, 20.0])


REFUSED = {
    "": r"is empty; its first line must name the columns",
    "# remark\n": r"is empty",
    "time,a\n": r"no line of numbers",
    "t,a\n1,2\n": r"line 1: no column is named 'time'; the columns are 't, a'",
    "time\n1\n": r"line 1: 'time' is the only column",
    "time,a,a\n1,2,3\n": r"line 1, column 3: 'a' is there already",
    "time,\n1,2\n": r"line 1, column 2: '' is no name",
    "time,a [N\n1,2\n": r"line 1, column 2: 'a \[N' is no name; write one such as 'hub_torque",
    "time,a\n1,2\n2\n": r"line 3 has 1 cells, and line 1 names 2 columns",
    "#\ntime,a\n1,2,3\n": r"line 3 has 3 cells, and line 2 names 2 columns",
    "time,a\n1,2\n2,fast\n": r"line 3, column 'a': 'fast' is no number; write a number, or leave it empty",
    "time;a\n0;0,5\n": r"line 2, column 'a': '0,5' is no number; write a point for the decimals",
    "time,a\n1,1_000\n": r"line 2, column 'a': '1_000' is no number",
    "0,1\n1,2\n": r"line 1 holds numbers; the first line must name the columns",
    "time,a\n1,inf\n": r"line 2, column 'a': inf is not finite",
    "time,a\n1,1e999\n": r"line 2, column 'a': inf is not finite",
    "time,a\n,2\n": r"line 2: the time is missing",
    "time,a\n1,2\n\n1,3\n": r"line 4: time 1 s comes after 1 s; order the values by time",
    "time [ms],a\n2,2\n1,3\n": r"line 3: time 0\.001 s comes after 0\.002 s",
    "time [kg],a\n1,2\n": r"line 1, column 'time': 'kg' is a mass; must be a unit of a time, such as 's'",
    "time [secundos],a\n1,2\n": r"line 1, column 'time': unit 'secundos' is not known",
    "time [s;import os],a\n1,2\n": r"is no unit",
    "time,a\n1,\0\n": r"holds a NUL",
    b"time,a\n1,\xff\n": r"byte 9 is no UTF-8 text; save the table as CSV in UTF-8",
    f"time,a\n1,{'2' * 200_000}\n": r"line 2: field larger than field limit",
    "time [9**9**9**9 s],a\n1,2\n": r"is no unit",
}


@pytest.mark.parametrize("content", REFUSED, ids=[re.sub("[^a-z0-9]+", "-", str(key)[:24]) for key in REFUSED])
def test_what_is_no_table_is_refused(tmp_path: Path, content: str | bytes) -> None:
    path = table(tmp_path, content)
    with pytest.raises(InputError, match=REFUSED[content]) as caught:
        read_experiment(path)
    assert str(path) in str(caught.value)


def test_what_is_no_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(MissingFileError, match="no measured curves at"):
        read_experiment(tmp_path / "none.csv")
    with pytest.raises(InputError, match="it is a folder"):
        read_experiment(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="it is a pipe"):
        read_experiment(tmp_path / "pipe")
    monkeypatch.setattr(experiment_file, "MOST_BYTES", 10)
    with pytest.raises(InputError, match="at most 10 are read"):
        read_experiment(table(tmp_path, "time,a\n1,2\n"))
    monkeypatch.setattr(experiment_file, "MOST_BYTES", 1000)
    monkeypatch.setattr(experiment_file, "MOST_COLUMNS", 2)
    with pytest.raises(InputError, match="names 3 columns, and at most 2"):
        read_experiment(table(tmp_path, "time,a,b\n1,2,3\n"))
