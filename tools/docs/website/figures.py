"""Figures that scripts of the gallery have made without pyplot, and their views of runs, as its pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from membrane_rs.plotting import save_figure
from membrane_rs.plotting.styled_figure import StyledFigure
from membrane_rs.plotting.viewer import NotebookView
from sphinx_gallery.scrapers import figure_rst


def figures_of_block(_block: object, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the figures and views that a block has made, and give the text that shows them.

    The arguments are those of a scraper of sphinx-gallery. Each is shown by the first block that has it.
    """
    shown = block_vars["example_globals"].setdefault("_shown_figures", [])
    files = []
    for value in list(block_vars["example_globals"].values()):
        if not isinstance(value, (StyledFigure, NotebookView)) or any(value is figure for figure in shown):
            continue
        shown.append(value)
        files.append(next(block_vars["image_path_iterator"]))
        if isinstance(value, NotebookView):
            Path(files[-1]).unlink(missing_ok=True)  # of a build before; a view replaces no file
            value.save(files[-1])
        else:
            save_figure(value, files[-1], dpi=150.0)
    text: str = figure_rst(files, gallery_conf["src_dir"])
    return text
