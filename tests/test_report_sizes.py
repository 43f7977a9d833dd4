"""A page shows shapes of all sizes whole: none is too small, too large, or beyond the edge of the picture."""

from __future__ import annotations

from pathlib import Path

import membrane_rs
import numpy as np
import pytest
from browser import opened
from membrane_rs import Fixed, Gravity, Material, Run, Scene, Simulation, Springs
from membrane_rs.folding import Strip
from membrane_rs.plotting.camera import ANGLE_DEG
from membrane_rs.report import pictures as report_pictures
from membrane_rs.report import write_report
from membrane_rs.report.deployment import deployment

pytestmark = pytest.mark.filterwarnings("ignore::membrane_rs.errors.AuditWarning")


def strip(length: float) -> Run:
    """Some steps of a strip of rubber of a length [m]."""
    mesh = Strip(length, 0.4 * length, 4, 2).mesh()
    rubber = Material(1e6, 1 / 3, 1000.0, 1e-3 * length)
    laws = [Springs(), Gravity((0.0, 0.0, -1e-4 / length))]  # all lengths move alike, in steps of their own
    scene = Scene(mesh, rubber, laws, [Fixed("start")], name=f"strip{length:g}")
    return membrane_rs.run(scene, 40.0 * Simulation(scene).dt, frames=2)


def test_micrometres_and_kilometres_are_seen_chosen_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report_pictures, "_drawn", lambda _: [])  # a contact sheet takes seconds
    runs = [strip(length) for length in (1e-6, 0.1, 1e3)]
    page = write_report(runs, tmp_path / "page.html")
    shares = []
    with opened() as browser:
        browser.open(page)
        for key in ("run-0", "run-1", "run-2"):
            choice = "const s = document.getElementById('view-run'); s.value = arguments[0];"
            browser.run(f"{choice} s.dispatchEvent(new Event('change'))", key)
            browser.wait(lambda: browser.find("#view-view").get_attribute("data-state") == "ready", "it drew")
            pixels = browser.pixels("#view-canvas").astype(int)
            shares.append(float((np.abs(pixels - pixels[-1, -1]).max(axis=2) > 20).mean()))
    assert shares[1] > 0.02
    assert shares == pytest.approx([shares[1]] * 3, rel=0.1)


@pytest.mark.parametrize("scene", ["spinning-disc", "hanging-strip"])
def test_all_of_a_shape_is_within_the_picture(scene: str) -> None:
    run = membrane_rs.run(scene, 1e-3, frames=2)
    meta = deployment(run).meta
    assert meta is not None
    view, up = np.array(meta["view"]), np.array(meta["up"])
    eye = np.array(meta["centre_of_view"]) + meta["distance"] * view
    angles = np.linspace(0.0, 2.0 * np.pi, 60) if meta["turns"] else [0.0]
    for angle in angles:
        c, s = np.cos(angle), np.sin(angle)
        points = run.frames[1].positions @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        heights = ((points - eye) @ up) / ((eye - points) @ view) / np.tan(np.radians(0.5 * ANGLE_DEG))
        assert np.abs(heights).max() < 1.0
