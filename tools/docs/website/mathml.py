"""Equations as MathML, which browsers draw themselves: no script and no font from elsewhere.

docutils converts LaTeX; what it does not know is a warning, and so an error of `make docs`.
"""

from __future__ import annotations

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.math import get_node_equation_number
from sphinx.util.typing import ExtensionMetadata
from sphinx.writers.html5 import HTML5Translator

_LOGGER = logging.getLogger(__name__)


def inline(self: HTML5Translator, node: nodes.math) -> None:
    """An equation in a line."""
    self.body.append(f'<span class="math">{_converted(node, is_block=False)}</span>')
    raise nodes.SkipNode


def block(self: HTML5Translator, node: nodes.math_block) -> None:
    """An equation in lines of its own, with its number if it has one."""
    self.body.append(self.starttag(node, "div", CLASS="math"))
    if node.get("number"):
        self.body.append(f'<span class="eqno">({get_node_equation_number(self, node)})</span>')
    self.body.append(f"{_converted(node, is_block=True)}</div>\n")
    raise nodes.SkipNode


def _converted(node: nodes.Element, *, is_block: bool) -> str:
    source = node.astext().strip()
    try:
        return str(tex2mathml(source, as_block=is_block))
    except MathError as error:
        _LOGGER.warning("equation %r: %s", source, error, location=node)
        return str(nodes.Text(source))


def setup(app: Sphinx) -> ExtensionMetadata:
    """Name the renderer, which conf.py chooses."""
    app.add_html_math_renderer("mathml", inline_renderers=(inline, None), block_renderers=(block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
