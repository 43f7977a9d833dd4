"""The energy balance of a run: its terms against time, and a table of what each law has exchanged in each stage."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.plotting.columns import prefixed
from membrane_rs.plotting.energy import LEAST, MOTOR, RESIDUAL, label, line_of, since_start, term_changes
from membrane_rs.plotting.page_panel import Curve, panel_svg
from membrane_rs.report.curves import changes, drawable, stage_names
from membrane_rs.report.markup import drawing, element, table
from membrane_rs.report.sources import BLACK, RUN_COLORS, LabelledRun
from membrane_rs.report.summaries import sound_stage_records

_GREY = "#888888"


def energy_section(labelled: LabelledRun) -> Element:
    """Figure, error and table."""
    history = {name: drawable(values) for name, values in labelled.run.history.items()}
    section = element("section", element("h2", "Energy balance"))
    if len(history["time"]) < 2 or not _has_balance(history):
        section.append(element("p", "This run has too few samples for a balance."))
        return section
    terms = since_start(history)
    sizes = {name: float(np.nanmax(np.abs(values), initial=0.0)) for name, values in terms.items()}
    unit, symbol = prefixed("J", list(terms.values()))
    most = max((size for name, size in sizes.items() if name != MOTOR), default=0.0)
    shown = [name for name, size in sizes.items() if name == MOTOR or size > LEAST * most]
    starts = stage_names(labelled)
    figures = element("div", class_="panels balance")
    wide = panel_svg(
        [_curve(history["time"], terms[name] / unit, name, shown) for name in shown],
        f"Since the start [{symbol}]",
        stages=starts,
        legend=bool(shown),
    )
    words = "; ".join(f"{label(name)} {terms[name][-1] / unit:.4g} {symbol}" for name in shown)
    figures.append(
        element(
            "figure",
            drawing(wide, f"{labelled.key}-energy", f"Terms of the energy balance against time; at the end: {words}"),
        )
    )
    if changes("energy_error", history):
        error = panel_svg(
            [Curve(history["time"], 100.0 * history["energy_error"])],
            "Energy error [% of the reference energy]",
            level=0.0,
            stages=starts,
        )
        figures.append(
            element(
                "figure",
                drawing(
                    error,
                    f"{labelled.key}-error",
                    f"Energy error against time, at the end {100.0 * history['energy_error'][-1]:.3g} %",
                ),
            )
        )
    section.append(figures)
    section.append(_table(labelled, history, terms, unit, symbol))
    note = (
        "What moves and what is stored has changed by the works of the laws, up to the residual. The work of the motor "
        "that turns the hub is no term of this balance, which is that of the turning frame. Terms that stay below "
        f"{100.0 * LEAST:.2g} % of the largest are not drawn."
    )
    section.append(element("p", note, class_="note"))
    return section


def _has_balance(history: Mapping[str, Floats]) -> bool:
    return "kinetic_energy" in history and "energy_error" in history


def _curve(time: Floats, values: Floats, name: str, shown: list[str]) -> Curve:
    """A term: energies solid, works dashed, the motor black."""
    look = line_of(name, shown)
    color = str(look["color"])
    shade = {"black": BLACK, "0.6": _GREY}.get(color) or RUN_COLORS[int(color.removeprefix("C")) % len(RUN_COLORS)]
    return Curve(time, values, label(name), shade, "term", str(look["linestyle"]), width=1.4)


def _table(
    labelled: LabelledRun, history: Mapping[str, Floats], terms: Mapping[str, Floats], unit: float, symbol: str
) -> Element:
    """One row for each term, one column for each stage that the summary knows, and one for the run."""
    records = sound_stage_records(labelled.run.summary)
    error = float(history["energy_error"][-1] * history["reference_energy"][-1])
    totals = {name: float(values[-1]) for name, values in terms.items()} | {RESIDUAL: error}
    spans = [term_changes(history, records, k) for k in range(len(records))] if len(records) > 1 else []
    order = sorted(totals, key=lambda name: (name == MOTOR, name == RESIDUAL, name.startswith("work_")))
    rows = []
    for name in order:
        row = [span.get(name, 0.0) for span in spans] + [totals[name]]
        if any(row) or name in (RESIDUAL, MOTOR):
            rows.append([label(name), *(_signed(value / unit) for value in row)])
    head = [f"Change or work [{symbol}]", *(record.name for record in records[: len(spans)]), "whole run"]
    return element("div", table(head, rows, class_="numbers"), class_="scrolls")


def _signed(value: float) -> str:
    """With four decimals and its sign; "0" where they show nothing."""
    shown = f"{value:+.4f}"
    return "0" if float(shown) == 0.0 else shown
