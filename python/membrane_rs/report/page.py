"""The page: one HTML file with all that it needs."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files
from xml.etree.ElementTree import Element

from membrane_rs.report import library
from membrane_rs.report.curves import curve_section
from membrane_rs.report.deployment import Shown, deployment
from membrane_rs.report.energy import energy_section
from membrane_rs.report.facts import audit_section, headline, outcome_banner, readings, scene_section, timing_section
from membrane_rs.report.markup import data, element, page_text, script
from membrane_rs.report.pictures import sheet_section
from membrane_rs.report.sources import LabelledRun, Sources

_NO_NETWORK = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; style-src 'unsafe-inline'; img-src data: blob:"
    "; worker-src blob:"
)
"""What a browser is to allow the page: nothing from outside it."""
_WITHOUT_SCRIPTS = (
    "JavaScript is off in this browser, so there is no picture in 3D. Below are the contact sheets, curves and "
    "tables of all runs; measures are those at the end."
)
SPEEDS = {"0.25": "1/4 x", "0.5": "1/2 x", "1": "1 x", "2": "2 x", "4": "4 x"}
CAMERAS = {"turning": "turns with the hub", "fixed": "stands still"}


def page(sources: Sources, title: str) -> str:
    """The text of the page."""
    shown = [deployment(labelled.run, 1.0 / len(sources.runs)) for labelled in sources.runs]
    root = element("html", _head(title), lang="en")
    body = element("body", _header(sources, title))
    main = element("main")
    main.append(_deployment_section(sources, shown))
    _of_each(main, sources, sheet_section)
    main.append(curve_section(sources))
    for part in (energy_section, audit_section, timing_section, scene_section):
        _of_each(main, sources, part)
    body.append(main)
    body.append(_footer(sources))
    body.extend(_scripts(sources, shown))
    root.append(body)
    return page_text(root)


def _head(title: str) -> Element:
    from membrane_rs.results.run_summary import versions

    style = element("style")
    style.text = _asset("page.css")
    unscripted = element("style")
    unscripted.text = "#view-view figcaption, #view-stage, #view-controls, .run, .legend input { display: none; }"
    unscripted.text += " .deployment { display: block; } aside dl { margin-top: 1rem; }"
    return element(
        "head", element("meta", charset="utf-8"),
        Element("meta", {"http-equiv": "Content-Security-Policy", "content": _NO_NETWORK}),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("meta", name="generator", content=f"membrane_rs {versions()['membrane_rs']}"),
        element("title", title), style, element("noscript", unscripted),
    )  # fmt: skip


def _header(sources: Sources, title: str) -> Element:
    """Title, what is not as planned, and the choice of a run."""
    header = element("header", element("h1", title))
    several = len(sources.runs) > 1
    for labelled in sources.runs:
        banner = outcome_banner(labelled)
        if banner is not None and several:
            banner.insert(0, element("span", f"{labelled.label}: "))
        if banner is not None:
            header.append(banner)
    if several:
        choice = element(
            "select",
            *(element("option", labelled.label, value=labelled.key) for labelled in sources.runs),
            id="view-run",
        )
        header.append(element("label", "Run ", choice, class_="run"))
    return header


def _of_each(main: Element, sources: Sources, part: Callable[[LabelledRun], Element | None]) -> None:
    """A section for each run; that of the chosen one is shown."""
    for labelled in sources.runs:
        section = part(labelled)
        if section is None:
            continue
        if len(sources.runs) > 1:
            section.set("data-of-run", labelled.key)
            section[0].append(element("small", f" {labelled.label}"))
        main.append(section)


def _deployment_section(sources: Sources, shown: list[Shown]) -> Element:
    """The picture in 3D with its controls, and numbers beside it."""
    section = element("section", element("h2", "Deployment"), id="deployment")
    numbers = element("aside")
    for labelled in sources.runs:
        part = element("div", headline(labelled), readings(labelled))
        if len(sources.runs) > 1:
            part.set("data-of-run", labelled.key)
        numbers.append(part)
    section.append(element("div", _viewer(shown), numbers, class_="deployment"))
    return section


def _viewer(shown: list[Shown]) -> Element:
    """The picture, and its controls."""
    stage = element(
        "div", element("div", id="view-canvas"), id="view-stage", hidden=all(one.meta is None for one in shown)
    )
    stage.append(element("div", id="view-label", class_="label", role="status"))
    words = "The deployment in 3D. Space plays, arrows go from frame to frame, Home and End to the ends."
    failed = (
        "This browser shows no 3D picture, which needs WebGL and DecompressionStream. The contact sheet shows the run, "
        "and a click on a curve the measures at its time. The reason: "
    )
    viewer = element(
        "figure", stage, id="view-view", tabindex="0", role="group", aria_label=words, data_state="loading"
    )
    viewer.append(element("div", id="view-scale", class_="scale", hidden=True))
    viewer.append(element("p", failed, element("span", id="view-reason"), id="view-failed", hidden=True))
    viewer.append(element("noscript", element("p", _WITHOUT_SCRIPTS)))
    viewer.append(_controls())
    keys = "Drag turns, the wheel zooms, the right button shifts; space plays. A click on a curve goes to its time."
    viewer.append(element("figcaption", element("span", keys, id="view-help"), " ", element("span", id="view-note")))
    return viewer


def _controls() -> Element:
    controls = element("div", id="view-controls", class_="controls")
    controls.append(element("button", "▶ Play", id="view-play", type="button"))
    controls.append(
        element("input", id="view-time", type="range", min="0", max="0", step="1", value="0", aria_label="Time")
    )
    for words, name, options, first in (
        ("Speed", "view-speed", SPEEDS, "1"), ("Colour", "view-field", {}, ""),
        ("Camera", "view-frame", CAMERAS, "turning"),
    ):  # fmt: skip
        choices = [element("option", text, value=value, selected=value == first) for value, text in options.items()]
        controls.append(element("label", f"{words} ", element("select", *choices, id=name)))
    controls.append(element("label", element("input", id="view-follow", type="checkbox"), "follows the size"))
    back = "Back to the view of the contact sheet"
    controls.append(element("button", "Reset view", id="view-home", type="button", title=back))
    return controls


def _footer(sources: Sources) -> Element:
    licence = element(
        "details", element("summary", "3D by k3d, under the MIT licence"), element("pre", library.licence())
    )
    return element(
        "footer",
        element(
            "p", "Made by membrane_rs. This page needs no network; its numbers are those of the folders of the runs."
        ),
        licence,
    )


def _scripts(sources: Sources, shown: list[Shown]) -> list[Element]:
    """Data, k3d, and what the page does."""
    runs = [
        {"run": labelled.key, "meta": one.meta, "note": one.note}
        for labelled, one in zip(sources.runs, shown, strict=True)
    ]
    found = [data({"runs": runs}, id="deployments")]
    for k, one in enumerate(shown):
        if one.meta is not None:
            found.append(script(one.data, type="text/plain", id=f"data-{k}"))
    if any(one.meta is not None for one in shown):
        found.append(script(library.source(), type="text/plain", id="k3d-source"))
        found.append(script(library.plot(), type="text/plain", id="k3d-plot"))
    found.append(script(_asset("viewer.js")))
    found.append(script(_asset("page.js")))
    return found


def _asset(name: str) -> str:
    return files("membrane_rs.report").joinpath("assets").joinpath(name).read_text("utf-8")
