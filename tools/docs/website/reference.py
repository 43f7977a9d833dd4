"""Pages of the reference, docs/reference/, written from the public names when the site is built; git ignores them."""

from __future__ import annotations

import importlib
from itertools import groupby
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

from website.public import PACKAGES, PublicName, members, public_names

GROUPS = (
    ("membrane_rs.scene.laws", "Laws"),
    ("membrane_rs.scene.parts", "Parts"),
    ("membrane_rs.scene.held", "Parts"),
    ("membrane_rs.scene.bodies", "Bodies"),
    ("membrane_rs.errors", "Errors and warnings"),
    ("membrane_rs.scene", "Scenes"),
    ("membrane_rs.mesh", "Scenes"),
    ("membrane_rs.material", "Scenes"),
    ("", "Runs"),
)
"""Headings of the names of `membrane_rs` itself, by the module that defines them."""
ORDER = ("Scenes", "Laws", "Parts", "Bodies", "Runs", "Errors and warnings")


def setup(app: Sphinx) -> ExtensionMetadata:
    """Write the pages before Sphinx reads the sources."""
    app.connect("config-inited", lambda app, config: write(Path(app.srcdir) / "reference"), priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write(folder: Path) -> None:
    """A page for each package and one for each of its names; pages of names that are gone are removed."""
    names = public_names()
    pages = {f"{name.path}.rst": page_of(name) for name in names}
    for package in PACKAGES:
        own = [name for name in names if name.package == package]
        pages[f"{package}.rst"] = package_page(package, own)
    pages["index.rst"] = index_page()
    folder.mkdir(exist_ok=True)
    for path in folder.glob("*.rst"):
        if path.name not in pages:
            path.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def titled(title: str, line: str = "=") -> str:
    """A heading."""
    return f"{title}\n{line * len(title)}\n\n"


def index_page() -> str:
    """The packages, each with the first line of its docstring."""
    text = f"{titled('Reference')}All that is public; a name is described where it is first imported from.\n\n"
    for package in PACKAGES:
        about = (importlib.import_module(package).__doc__ or "").partition("\n")[0]
        text += f":doc:`{package} <{package}>`\n    {about}\n\n"
    entries = "".join(f"   {package}\n" for package in PACKAGES)
    return f"{text}.. toctree::\n   :hidden:\n\n{entries}"


def package_page(package: str, names: list[PublicName]) -> str:
    """What a package is for, and its names with their summaries; those described elsewhere are links."""
    text = f"{titled(package)}.. py:module:: {package}\n\n.. automodule:: {package}\n   :no-index:\n\n"
    groups = grouped(package, names)
    for heading, group in groups:
        text += titled(heading, "-") if heading else ""
        entries = "".join(f"   {name.name}\n" for name in group)
        text += f".. currentmodule:: {package}\n\n.. autosummary::\n   :nosignatures:\n\n{entries}\n"
    own = {name.name for name in names}
    listed = importlib.import_module(package).__all__
    other = [name for name in listed if name not in own and not name.startswith("__")]
    if other:
        text += "Also here: " + ", ".join(f":py:obj:`{name} <{place(package, name)}>`" for name in other) + ".\n\n"
    entries = "".join(f"   {name.path}\n" for _, group in groups for name in group)
    return text + (f".. toctree::\n   :hidden:\n\n{entries}" if names else "")


def place(package: str, name: str) -> str:
    """Where a name of a package is described."""
    value = getattr(importlib.import_module(package), name)
    return next((other.path for other in public_names() if other.value is value), f"{package}.{name}")


def grouped(package: str, names: list[PublicName]) -> list[tuple[str, list[PublicName]]]:
    """Names under headings; a small package has none."""
    if package != "membrane_rs":
        return [("", names)] if names else []

    def heading(name: PublicName) -> str:
        return next(title for start, title in GROUPS if name.group.startswith(start))

    ranked = sorted(names, key=lambda name: (ORDER.index(heading(name)), name.name))
    return [(title, list(group)) for title, group in groupby(ranked, key=heading)]


def page_of(name: PublicName) -> str:
    """A name by itself: a class with its methods and properties."""
    text = f"{titled(name.name)}.. currentmodule:: {name.package}\n\n.. auto{name.kind}:: {name.name}\n"
    if name.kind == "class" and (listed := members(name.value)):
        text += f"   :members: {', '.join(listed)}\n"
    return text
