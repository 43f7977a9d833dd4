"""A figure of matplotlib that is drawn in its own style, whatever the settings are by then."""

from __future__ import annotations

import io
from typing import Any

from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure

from membrane_rs.plotting.style import PAPER, Style

MOST_SHOWN = 150.0
"""Resolution in a notebook, at most [1/inch]."""


class StyledFigure(Figure):
    """A figure without pyplot that keeps its style: ticks, for one, are made as late as when it is drawn."""

    style: Style = PAPER

    def draw(self, renderer: RendererBase) -> None:
        """Draw it in its style."""
        with self.style.context():
            super().draw(renderer)

    def savefig(self, fname: Any, **options: Any) -> None:
        """Save it as `Figure.savefig` does, in its style and, unless said otherwise, at its resolution."""
        with self.style.context():
            super().savefig(fname, **{"dpi": self.style.dpi, **options})

    def _repr_png_(self) -> bytes:
        """The figure in a notebook."""
        content = io.BytesIO()
        self.savefig(content, format="png", dpi=min(self.style.dpi, MOST_SHOWN))
        return content.getvalue()
