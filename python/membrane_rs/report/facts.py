"""What a page says of a run in words and numbers: how it ended, what the audit found, what it cost, what was run."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from membrane_rs.plotting.columns import axis_label, label_of, prefixed
from membrane_rs.report.curves import FIRST, changes, drawable, finite, is_measure
from membrane_rs.report.markup import Content, add, element, prose, table
from membrane_rs.report.sources import LabelledRun
from membrane_rs.report.summaries import is_number, table_of, tables_of

FINISHED = "finished"
UNKNOWN = "?"
SAMPLES = 300
"""Times of the values beside the picture."""
MOST_READINGS = 8
RPM = 30.0 / np.pi
"""Turns per minute of one radian per second."""
_SEVERITY = {"error": "Error", "warning": "Warning", "info": "Fact"}
_OUTCOMES = {
    "unstable": "This run stopped itself",
    "failed": "This run failed",
    "running": "This run still goes on",
}
_RESUME = "`membrane-rs resume` goes on with it."
_REMEDIES = {
    "running": "A process goes on with it; make this page again when it has ended.",
    "killed": _RESUME,
    "interrupted": _RESUME,
}
_CURVES = {
    "final_rate": ("Final deployment rate", "", "{:.4f}"),
    "highest_rate": ("Highest deployment rate", "", "{:.4f}"),
    "first_peak_rate": ("First peak of the rate", "", "{:.4f}"),
    "first_peak_time": ("Time of the first peak", "s", "{:.4g}"),
    "phase_trough_deg": ("Trough of the phase", "deg", "{:.1f}"),
    "zero_crossing_time": ("Zero crossing of the phase", "s", "{:.4g}"),
}


def outcome_banner(labelled: LabelledRun) -> Element | None:
    """How a run ended that did not end as planned, its cause first."""
    outcome = labelled.run.outcome
    if outcome == FINISHED:
        return None
    head, _, cause = outcome.partition(": ")
    words = _OUTCOMES.get(head, f"This run was {head}")
    at, end = _reached(labelled), labelled.run.summary.get("until")
    when = f" at {at:.6g} s" if is_number(at) else ""
    when += f" of {end:.6g} s" if when and is_number(end) else ""
    kind = "fault" if head in ("unstable", "failed") else "unfinished"
    return element(
        "div",
        element("strong", f"{words}{when}."),
        f" {cause} " if cause else " ",
        *prose(_REMEDIES.get(head, "")),
        class_=f"banner {kind}",
        role="alert",
    )


def _is_of_start(labelled: LabelledRun) -> bool:
    """Whether the summary of a run is that of its start, since no end was written."""
    return labelled.run.outcome in ("running", "killed")


def _reached(labelled: LabelledRun) -> object:
    """Time to which a run has come [s]."""
    times = labelled.run.history["time"]
    return float(times[-1]) if _is_of_start(labelled) and len(times) else labelled.run.summary.get("time")


def headline(labelled: LabelledRun) -> Element:
    """The numbers of a run in short."""
    run, rows = labelled.run, []
    counts = table_of(run.summary, "counts")
    size = ", ".join(
        f"{counts[name]:,} {name}" for name in ("nodes", "triangles", "springs") if is_number(counts.get(name))
    )
    if labelled.label != run.scene.name:
        rows.append(("Run", labelled.label))
    rows.append(("Scene", run.scene.name))
    rows.append(("Size", size))
    time, wall = _reached(labelled), run.summary.get("wall_time")
    if is_number(time):
        took = f" in {duration(wall)}" if is_number(wall) and not _is_of_start(labelled) else ""
        rows.append(("Simulated", f"{time:.6g} s{took}"))
    curves = table_of(run.summary, "curves")
    turns = changes("phase_difference_deg", run.history)
    for name, (words, unit, form) in _CURVES.items():
        value = curves.get(name)
        if is_number(value) and (turns or not name.startswith(("phase", "zero"))) and _unfolds(labelled):
            rows.append((words, f"{form.format(value)} {unit}".strip()))
    balance = table_of(run.summary, "energy_balance")
    error = balance.get("error")
    if is_number(error):
        rows.append(("Energy error at the end", f"{100.0 * error:+.3g} %"))
    momentum = run.summary.get("momentum_error")
    if is_number(momentum):
        rows.append(("Error of the angular momentum", f"{100.0 * momentum:.2g} %"))
    rates = finite(run.history["hub_rate"]) if "hub_momentum" in run.history else np.zeros(0)
    if len(rates):
        rows.append(("Rate of the hub", f"from {RPM * rates[0]:.4g} to {RPM * rates[-1]:.4g} rpm"))
    return _pairs([(name, value) for name, value in rows if value])


def _unfolds(labelled: LabelledRun) -> bool:
    return changes(FIRST[0], labelled.run.history)


def readings(labelled: LabelledRun) -> Element | None:
    """Values at the time of the picture: a table that the page fills."""
    history = labelled.run.history
    names = [name for name in history if is_measure(name) and changes(name, history)]
    time = history["time"]
    if not names or not len(time):
        return None
    picks = np.unique(np.linspace(0, len(time) - 1, min(len(time), SAMPLES)).round().astype(int))
    rows: list[Sequence[Content]] = []
    for name in names[:MOST_READINGS]:
        factor, unit = prefixed(history.units.get(name, ""), [drawable(history[name])])
        values = [f"{value:.4g}" if np.isfinite(value) else None for value in history[name][picks] / factor]
        cell = element(
            "output", values[-1] or UNKNOWN, data_samples=_json({"times": time[picks].tolist(), "values": values})
        )
        rows.append((axis_label(label_of(name), unit), cell))
    return table(("", ""), rows, caption="At the time of the picture", class_="readings")


def audit_section(labelled: LabelledRun) -> Element:
    """Findings of the audit, errors first."""
    found = tables_of(labelled.run.summary, "audit")
    section = element("section", element("h2", "Audit"))
    if not found:
        section.append(element("p", "The audit found nothing, or this run has none."))
        return section
    order = list(_SEVERITY)
    found.sort(key=lambda entry: order.index(entry["severity"]) if entry.get("severity") in order else len(order))
    items = element("ul", class_="findings")
    for entry in found:
        severity = str(entry.get("severity", ""))
        remedy = str(entry.get("remedy") or "")
        item = element("li", element("span", _SEVERITY.get(severity, severity), class_="severity"), " ")
        item.set("class", severity if severity in _SEVERITY else "other")
        for part in prose(str(entry.get("message", ""))):
            add(item, part)
        add(item, element("div", *prose(remedy), class_="note") if remedy else None)
        items.append(item)
    section.append(items)
    return section


def timing_section(labelled: LabelledRun) -> Element:
    """What the run has cost, and each stage."""
    summary, section = labelled.run.summary, element("section", element("h2", "Timings"))
    costs = {name: cost for name, cost in _COSTS.items() if not (name in _COUNTED and _is_of_start(labelled))}
    rows = [(words, form(summary[name])) for name, (words, form) in costs.items() if _is_value(summary.get(name))]
    wall, steps = summary.get("wall_time"), summary.get("steps")
    if is_number(wall) and isinstance(steps, int) and steps:
        rows.insert(2, ("Wall time of a step", f"{1e3 * wall / steps:.3g} ms"))
    section.append(_pairs(rows))
    stages = tables_of(summary, "stages")
    if stages:
        head = ("Stage", "from [s]", "to [s]", "ended by", "method", "step [s]", "steps", "evaluations", "wall time")
        section.append(
            element("div", table(head, [_stage_row(entry) for entry in stages], class_="numbers"), class_="scrolls")
        )
    return section


def _is_value(value: object) -> bool:
    return isinstance(value, str) or is_number(value)


def _stage_row(entry: Mapping[str, Any]) -> list[str]:
    def shown(name: str, form: str = "{}") -> str:
        value = entry.get(name)
        try:
            return UNKNOWN if value is None else form.format(value)
        except (ValueError, TypeError):
            return str(value)

    wall = entry.get("wall_time")
    return [
        shown("name"), shown("start", "{:.6g}"), shown("end", "{:.6g}"), shown("ended_by"), shown("integrator"),
        shown("dt", "{:.3g}"), shown("steps", "{:,}"), shown("evaluations", "{:,}"),
        duration(wall) if is_number(wall) else UNKNOWN,
    ]  # fmt: skip


def scene_section(labelled: LabelledRun) -> Element:
    """The scene with all its values, and the versions of what ran it."""
    run = labelled.run
    versions, process = table_of(run.summary, "versions"), table_of(run.summary, "process")
    rows = [(name, str(value)) for name, value in versions.items()]
    if process.get("start"):
        rows.append(("begun", str(process["start"])))
    section = element("section", element("h2", "Scene"))
    section.append(
        element(
            "p", "The scene as it was run, every value resolved. Saved as a file, it can be run again.", class_="note"
        )
    )
    section.append(element("pre", element("code", run.scene.to_toml()), tabindex="0", aria_label="The scene as TOML"))
    if rows:
        section.append(element("h3", "Versions"))
        section.append(_pairs(rows))
    return section


def duration(seconds: Any) -> str:
    """Seconds in the unit that fits."""
    if not isinstance(seconds, int | float):
        return str(seconds)
    if seconds < 120:
        return f"{seconds:.3g} s"
    return f"{seconds / 60:.3g} min" if seconds < 7200 else f"{seconds / 3600:.3g} h"


def _pairs(rows: Sequence[tuple[str, str]]) -> Element:
    """Names and values."""
    pairs = element("dl")
    for name, value in rows:
        pairs.append(element("div", element("dt", name), element("dd", value)))
    return pairs


def _whole(value: Any) -> str:
    return f"{value:,}" if isinstance(value, int | float) else str(value)


def _seconds(value: Any) -> str:
    return f"{value:.4g} s" if isinstance(value, int | float) else str(value)


def _json(content: Any) -> str:
    return json.dumps(content, allow_nan=False)


_COSTS: dict[str, tuple[str, Callable[[Any], str]]] = {
    "wall_time": ("Wall time", duration),
    "steps": ("Steps", _whole),
    "evaluations": ("Evaluations of the forces", _whole),
    "rejected_steps": ("Rejected steps", _whole),
    "newton_iterations": ("Newton iterations", _whole),
    "factorisations": ("Factorisations", _whole),
    "resumed": ("Resumed", _whole),
    "integrator": ("Method", str),
    "dt": ("Step", _seconds),
    "stable_dt": ("Stability limit at the start", _seconds),
    "limiting_part": ("Set by", str),
}
"""Entries of summary.json in words."""
_COUNTED = ("wall_time", "steps", "evaluations", "rejected_steps", "newton_iterations", "factorisations")
"""Those that grow with a run."""
