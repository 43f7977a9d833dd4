"""The site of docs/: equations, pages of the reference, links between pages, and nothing loaded from elsewhere."""

from __future__ import annotations

from pathlib import Path

import membrane_rs
import pytest
from documented import PAGES, ROOT
from docutils.utils.math.latex2mathml import tex2mathml
from markdown_it import MarkdownIt
from mdit_py_plugins.dollarmath import dollarmath_plugin
from website.offline import from_elsewhere, main
from website.public import PACKAGES, public_names
from website.reference import write
from website.repository import as_page


def equations() -> list[tuple[str, bool]]:
    """Each equation of a page, and whether it stands in lines of its own."""
    parser = MarkdownIt("commonmark").use(dollarmath_plugin)
    found: list[tuple[str, bool]] = []
    for page in PAGES:
        tokens = parser.parse(page.read_text(encoding="utf-8"))
        tokens += [child for token in tokens for child in token.children or ()]
        found += [(token.content, token.type == "math_block") for token in tokens if token.type.startswith("math")]
    return found


def test_every_equation_is_drawn() -> None:
    found = equations()
    assert any(is_block for _, is_block in found), "no page has an equation"
    for source, is_block in found:
        assert "<math" in tex2mathml(source.strip(), as_block=is_block)


def test_every_public_name_has_a_page(tmp_path: Path) -> None:
    write(tmp_path / "reference")
    pages = {path.stem for path in (tmp_path / "reference").glob("*.rst")}
    assert pages == {"index", *PACKAGES, *(name.path for name in public_names())}
    (tmp_path / "reference" / "gone.rst").write_text("a name that is gone")
    text = (tmp_path / "reference" / "membrane_rs.rst").read_text()
    assert text.count("   Scene\n") == 1
    write(tmp_path / "reference")
    assert not (tmp_path / "reference" / "gone.rst").exists()


@pytest.mark.parametrize(
    ("text", "page"),
    [
        ("[docs/stages.md](stages.md#rules)", "[Stages](stages.md#rules)"),
        ("[docs/stages.md](docs/stages.md)", "[Stages](stages.md)"),
        ("[times](benchmarks/README.md)", "[times](times.md)"),
        ("[a page](../docs/limits.md)", "[a page](limits.md)"),
        ("[elsewhere](https://semver.org)", "[elsewhere](https://semver.org)"),
    ],
)
def test_links_between_files_become_links_between_pages(text: str, page: str) -> None:
    assert as_page(text, ROOT / "docs") == page


@pytest.mark.parametrize(
    "loaded",
    [
        '<script src="https://a.test/x.js"></script>',
        '<link rel="stylesheet" href="//a.test/x.css">',
        '<img src="http://a.test/x.png">',
        '<img srcset="x.png 1x, https://a.test/x.png 2x">',
        "<style>@import 'https://a.test/x.css';</style>",
        '<p style="background: url(https://a.test/x.png)">',
        '<iframe src="HTTPS://a.test"></iframe>',
    ],
)
def test_what_a_page_loads_from_elsewhere_is_found(
    loaded: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.html"
    page.write_text('<a href="https://a.test">a link</a><link rel="next" href="b.html"><img src="c.png">')
    assert list(from_elsewhere(tmp_path)) == []
    assert main(tmp_path) == 0
    page.write_text(loaded)
    assert len(list(from_elsewhere(tmp_path))) == 1
    assert main(tmp_path) == 1
    assert "page.html: loads" in capsys.readouterr().err


def test_a_folder_without_pages_is_no_site(tmp_path: Path) -> None:
    assert main(tmp_path) == 1


def test_pictures_of_the_gallery_replace_those_of_a_build_before(tmp_path: Path) -> None:
    scrapers = pytest.importorskip("website.figures")
    view = membrane_rs.run("single-crease", until=1e-4, frames=2).view(where="picture")
    for _ in range(2):
        found = {"example_globals": {"view": view}, "image_path_iterator": iter([str(tmp_path / "picture.png")])}
        text = scrapers.figures_of_block(None, found, {"src_dir": str(tmp_path)})
        assert "picture.png" in text
        assert scrapers.figures_of_block(None, found, {"src_dir": str(tmp_path)}) == ""  # shown by one block alone
