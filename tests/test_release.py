"""What is published: metadata, links that lead somewhere, and a source archive that holds what they name."""

from __future__ import annotations

import re
import sys
from fnmatch import fnmatch
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest

tomllib = import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")
ROOT = Path(__file__).parents[1]
METADATA = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
LINKS = "https://example.org/files/main"


def script(name: str) -> ModuleType:
    """A script of tools/dist."""
    spec = spec_from_file_location(name, ROOT / "tools" / "dist" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    made = module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("![a](docs/a.png)", f"![a]({LINKS}/docs/a.png)"),
        ("[b](docs/b.md#part)", f"[b]({LINKS}/docs/b.md#part)"),
        ("[c](#part) [d](https://example.net/e)", "[c](#part) [d](https://example.net/e)"),
    ],
)
def test_links_become_absolute(text: str, expected: str) -> None:
    assert script("build").absolute(text, f"{LINKS}/") == expected


def test_the_metadata_name_the_address_where_it_is_known() -> None:
    urls = tomllib.loads(script("build").with_urls(METADATA, LINKS))["project"]["urls"]
    assert {name: url.removeprefix(f"{LINKS}/") for name, url in urls.items()} == {
        "Documentation": "docs/index.md", "Changelog": "CHANGELOG.md", "Citation": "CITATION.cff"
    }  # fmt: skip
    assert all((ROOT / url.removeprefix(f"{LINKS}/")).is_file() for url in urls.values())


def test_the_source_archive_holds_what_the_readme_links_to() -> None:
    patterns = [entry["path"] for entry in tomllib.loads(METADATA)["tool"]["maturin"]["include"][1:]]
    linked = re.findall(r"\]\((?!https?://|#)([^)#\s]+)", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert len(linked) > 10
    for name in linked:
        assert (ROOT / name).exists(), name
        is_packed = any(fnmatch(name, pattern.replace("**/*", "*")) for pattern in patterns)
        assert is_packed or name == "LICENSE", name


def test_each_extra_is_described_on_the_page_of_installing() -> None:
    page = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
    described = re.findall(r"^\| `(\w+)` \|", page, flags=re.MULTILINE)
    assert described == list(tomllib.loads(METADATA)["project"]["optional-dependencies"])
