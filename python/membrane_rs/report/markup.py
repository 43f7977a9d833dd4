"""Elements of the page: a tree, so that whatever is text stays text."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

Content = Element | str | None
"""What an element may hold; None is left out."""
_REFERENCE = re.compile(r"((?:^|url\()#)")
_SVG = "{http://www.w3.org/2000/svg}"


def element(tag: str, *content: Content, **attributes: str | bool | None) -> Element:
    """An element with text and others in it.

    Attributes are named with `_` in place of `-`, and with a `_` behind where Python has the word; True is one without
    a value, None and False are left out.
    """
    made = Element(tag)
    for name, value in attributes.items():
        if value is not None and value is not False:
            made.set(name.rstrip("_").replace("_", "-"), "" if value is True else clean(str(value)))
    for part in content:
        add(made, part)
    return made


def add(parent: Element, part: Content) -> None:
    """Add text or an element to another."""
    if part is None:
        return
    if not isinstance(part, str):
        parent.append(part)
    elif len(parent):
        parent[-1].tail = (parent[-1].tail or "") + clean(part)
    else:
        parent.text = (parent.text or "") + clean(part)


def prose(text: str) -> list[Content]:
    """The parts of a text in which pairs of backticks enclose code. With a backtick too many it stays as it is."""
    pieces = text.split("`")
    if len(pieces) % 2 == 0:
        return [text]
    return [element("code", piece) if k % 2 else piece for k, piece in enumerate(pieces)]


def clean(text: str) -> str:
    """A text without what no page may hold: control characters and halves of surrogate pairs."""
    kept = "".join(letter if letter >= " " or letter in "\n\t" else "\ufffd" for letter in text)
    return kept.encode("utf-8", "replace").decode("utf-8")


def table(head: Sequence[str], rows: Iterable[Sequence[Content]], caption: str = "", **attributes: str) -> Element:
    """A table whose first column names its rows."""
    made = element("table", element("caption", caption) if caption else None, **attributes)
    if any(head):
        made.append(element("thead", element("tr", *(element("th", word, scope="col") for word in head))))
    body = element("tbody")
    for first, *others in rows:
        body.append(element("tr", element("th", first, scope="row"), *(element("td", cell) for cell in others)))
    made.append(body)
    return made


def script(text: str, **attributes: str) -> Element:
    """A script, or data that are no HTML, as they are. Raises ValueError where a text would end the element."""
    if "</" in text.lower() and ("</script" in text.lower() or "</style" in text.lower()):
        raise ValueError("a script holds the end of an element")
    made = Element("script", {name.rstrip("_"): value for name, value in attributes.items()})
    made.text = text
    return made


def data(content: Any, **attributes: str) -> Element:
    """Values as JSON, in which no `<` stands, so that no text in them is taken for HTML."""
    text = json.dumps(content, allow_nan=False).replace("<", "\\u003c").replace("\u2028", "\\u2028")
    return script(text, type="application/json", **attributes)


def drawing(svg: str, name: str, words: str) -> Element:
    """An SVG figure as an element of the page, described in words; its own names begin with `name`, since a page has
    several figures.
    """
    figure = ElementTree.fromstring(svg)
    for part in list(figure.iter()):
        part.tag = str(part.tag).removeprefix(_SVG)
        for key in [key for key in part.attrib if key.startswith("{")]:
            part.set(key.partition("}")[2], part.attrib.pop(key))
        for key, value in part.attrib.items():
            part.set(key, _REFERENCE.sub(rf"\1{name}-", value))
        if "id" in part.attrib:
            part.set("id", f"{name}-{part.attrib['id']}")
    for parent in list(figure.iter()):
        for child in [child for child in parent if child.tag in ("metadata", "style")]:
            parent.remove(child)
    for key in ("width", "height", "version"):
        figure.attrib.pop(key, None)
    figure.set("role", "img")
    figure.set("aria-label", clean(words))
    return figure


def page_text(root: Element) -> str:
    """The whole page."""
    return "<!doctype html>\n" + ElementTree.tostring(root, encoding="unicode", method="html") + "\n"
