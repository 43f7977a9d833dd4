"""The report of runs, as a file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from membrane_rs._extras import need
from membrane_rs._files import check_kind_of_file, check_writable, path_of, write_text
from membrane_rs._validation import check_kind, flags_of, nearest, show
from membrane_rs.errors import InputError, InputTypeError, OutputError
from membrane_rs.report.sources import Sources, labelled
from membrane_rs.results.given_experiment import ExperimentLike, experiment_of, is_experiment
from membrane_rs.runs import Run, open_run

REPORT = "report.html"
MOST_RUNS = 100
MOST_NAMED = 4
"""Runs that the title names."""


def write_report(
    runs: Run | str | Path | Sequence[Run | str | Path],
    path: str | Path = REPORT,
    *,
    data: ExperimentLike | Sequence[ExperimentLike] = (),
    ensemble: bool = False,
    title: str | None = None,
    overwrite: bool = False,
) -> Path:
    """Write a page of one or several runs.

    It is one HTML file that opens from disk and loads nothing: the deployment in 3D, the contact sheet, curves of all
    runs over one another, and of the run that is chosen in the page the energy balance, the audit, timings and the
    scene.

    Parameters
    ----------
    runs : Run, path, or a list of them
        What `membrane_rs.run` gave, or folders of runs.
    path : path
        The file, "report.html" where not given.
    data : path, Experiment, mapping, pandas.DataFrame, or a list of them
        Measured curves to be drawn over those of the runs: CSV files with a column "time" and others named as in
        history.csv, see `membrane_rs.results.read_experiment`; the same in memory, or as arrays by name.
    ensemble : bool
        Draw the mean of the runs and one standard deviation to each side, for runs of one scene from several starts.
    title : str, optional
        Default: the name of the scene, or of the runs.
    overwrite : bool
        Replace a file that is there.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        No run, an ensemble of one or of several scenes, data without a column of the runs, a file that is no HTML.
    InputTypeError
        What is neither a run nor a path, or no measured curves.
    MissingFileError
        No run in a folder, no file of data.
    OutputError
        A run is damaged; the file is there, or cannot be written.
    MissingExtraError
        k3d, matplotlib or Pillow is not installed.

    Examples
    --------
    >>> import membrane_rs, tempfile
    >>> from membrane_rs.report import write_report
    >>> run = membrane_rs.run("spinning-tether", 1e-2, frames=3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_report(run, folder + "/tether.html").read_text()[:15]
    '<!doctype html>'
    """
    need("k3d", "matplotlib", "PIL", use="a page of runs")
    from membrane_rs.report.page import page

    ensemble, overwrite = flags_of(ensemble=ensemble, overwrite=overwrite)
    file = _file(path, overwrite)
    check_kind(title, (str, type(None)), "title", "a text")
    chosen = [_run(one, f"runs[{k}]") for k, one in enumerate(_list_of(runs, (Run, str, os.PathLike)))]
    if not chosen:
        raise InputError("runs: none is given; give a run or the folder of one")
    if len(chosen) > MOST_RUNS:
        raise InputError(f"runs: {len(chosen)} are given, and a page holds at most {MOST_RUNS}; leave some out")
    if ensemble and len(chosen) < 2:
        raise InputError("ensemble: one run has no spread; give several runs of the scene, or leave it out")
    for k, run in enumerate(chosen if ensemble else ()):
        if run.scene.name != chosen[0].scene.name:
            raise InputError(
                f"ensemble: runs[{k}] is of the scene {show(run.scene.name)}, runs[0] of {show(chosen[0].scene.name)}; "
                "give runs of one scene, or leave it out: their curves are then laid over one another"
            )
    units = {name: unit for run in reversed(chosen) for name, unit in run.history.units.items()}
    given = [data] if is_experiment(data) else _list_of(data, ())
    experiments = [experiment_of(one, units, f"data[{k}]", f"measured {k + 1}") for k, one in enumerate(given)]
    for experiment in experiments:
        if not any(name in units for name in experiment.columns):
            have = ", ".join(experiment.columns)
            meant = nearest(next(iter(experiment.columns)), [name for name in units if name != "time"])
            raise InputError(f"data {experiment.name}: its columns, {have}, are none of the runs; {meant}")
    sources = Sources(labelled(chosen), experiments, ensemble)
    write_text(file, page(sources, title or _title(sources)))
    return file


def _file(path: object, overwrite: bool) -> Path:
    """The file to be written, refused before anything is drawn."""
    file = path_of(path)
    check_kind_of_file(file, "text/html", "a page is HTML", ".html")
    if file.is_dir():
        raise OutputError(f"cannot write {file}: it is a folder; name a file in it, such as {file / REPORT}")
    if file.exists() and not overwrite:
        raise OutputError(f"{file} is there already; give another name, or replace it with overwrite (--overwrite)")
    if not file.parent.is_dir():
        raise OutputError(f"cannot write {file}: there is no folder {file.parent}; make it, or choose another one")
    check_writable(file)
    return file


def _run(given: object, place: str) -> Run:
    if isinstance(given, Run):
        return given
    if isinstance(given, str | Path | os.PathLike):
        path = path_of(given, place)
        if path.suffix.lower() == ".csv":
            raise InputError(f"{path}: is no folder of a run; measured curves are given as data (data=, --data)")
        return open_run(path)
    raise InputTypeError(f"{place} = {show(given)}: must be a run, or the folder of one")


def _list_of(given: object, kinds: tuple[type, ...]) -> list[Any]:
    """One thing, or the things of a list."""
    if isinstance(given, kinds):
        return [given]
    if not isinstance(given, Sequence):
        raise InputTypeError(f"{show(given)}: must be one, or a list of several")
    return list(given)


def _title(sources: Sources) -> str:
    """The name of the scene, or those of the runs."""
    labels, scenes = [one.label for one in sources.runs], {one.run.scene.name for one in sources.runs}
    if len(scenes) == 1:
        return f"{scenes.pop()}: {len(labels)} runs" if len(labels) > 1 else scenes.pop()
    return ", ".join(labels) if len(labels) <= MOST_NAMED else f"{', '.join(labels[:MOST_NAMED])} and others"
