"""CITATION.cff: read as YAML, complete by its format's rules, and at one with Cargo.toml, LICENSE and README."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).parent.parent
CITATION: dict[str, Any] = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_it_has_what_the_format_asks_for() -> None:
    assert CITATION["cff-version"] == "1.2.0"
    assert CITATION["type"] == "software"
    for work in (CITATION, *CITATION["references"]):
        assert work["title"]
        assert work["type"]
        assert all("name" in author or "family-names" in author for author in work["authors"])
    assert CITATION["message"]


def test_it_names_this_version_and_licence() -> None:
    workspace = (ROOT / "Cargo.toml").read_text(encoding="utf-8").partition("[workspace.package]")[2]
    for key in ("version", "license"):
        value = re.search(rf'^{key} = "(.+)"$', workspace, flags=re.MULTILINE)
        assert value is not None
        assert str(CITATION[key]) == value[1]


def test_it_names_the_paper_that_the_readme_names() -> None:
    (paper,) = CITATION["references"]
    cited = (ROOT / "README.md").read_text(encoding="utf-8").partition("## How to cite")[2]
    cited = " ".join(cited.replace("*", "").replace("\n> ", " ").split())
    first = paper["authors"][0]
    for words in (
        f"{first['given-names']} {first['family-names']}",
        paper["journal"],
        f"vol. {paper['volume']}, no. {paper['issue']}, {paper['year']}",
        paper["end"],
    ):
        assert words in cited
