"""The notebooks of docs/notebooks run from their first cell to their last, and show what they say."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "notebooks"
PICTURES = {"one_sail": 6, "own_sail": 4, "many_runs": 1}
"""How many pictures each shows at least."""
SECONDS = 300.0
"""A cell that takes longer fails; all of a notebook take seconds on a machine that does nothing else."""


def test_all_notebooks_are_run() -> None:
    assert {path.stem for path in FOLDER.iterdir()} == set(PICTURES)


@pytest.mark.parametrize("name", PICTURES)
def test_a_notebook_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    jupytext, nbclient = pytest.importorskip("jupytext"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    monkeypatch.setenv("PYVISTA_JUPYTER_BACKEND", "static")  # pictures, as in the site
    notebook: Any = jupytext.read(FOLDER / f"{name}.md")
    assert not any(cell.get("outputs") for cell in notebook.cells)
    resources = {"metadata": {"path": str(tmp_path)}}
    waits: Any = {"timeout": SECONDS, "startup_timeout": SECONDS}
    nbclient.NotebookClient(notebook, kernel_name="python3", resources=resources, **waits).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    warned = [output.text for output in outputs if output.output_type == "stream" and output.name == "stderr"]
    assert warned == []
    pictures = [output for output in outputs if "image/png" in str(dict(output.get("data", {})))]
    assert len(pictures) >= PICTURES[name]
