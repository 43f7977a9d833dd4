"""The site of the documentation, which `make docs` builds from the pages of this folder without a network."""

from __future__ import annotations

import os
import sys
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "tools" / "docs")]  # website/: extensions of this site
os.environ.setdefault("MPLBACKEND", "Agg")

project = "membrane_rs"
author = "the membrane_rs developers"
release = metadata.version("membrane_rs")

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_nb",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "website.mathml",
    "website.reference",
    "website.repository",
]
exclude_patterns = ["gallery/*.ipynb", "gallery/*.md5", "gallery/*.py", "**/.ipynb_checkpoints"]
nitpicky = True
# Types and terms of other packages: their pages are on the network, which the build does not use.
nitpick_ignore_regex = [("py:.*", r"(?s)(?!membrane_rs).*"), ("py:obj", r"(?s).*")]
default_role = "py:obj"
suppress_warnings = ["config.cache"]

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 4
nb_execution_mode = "force"
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_execution_in_temp = True
nb_render_markdown_format = "myst"  # with tables
os.environ["PYVISTA_JUPYTER_BACKEND"] = "static"  # pictures: no kernel serves the pages of a site
nb_ipywidgets_js: dict[str, dict[str, str]] = {}  # else from a network

autodoc_typehints = "none"
autodoc_member_order = "bysource"
autosummary_generate = False
toc_object_entries_show_parents = "hide"
numpydoc_show_class_members = False
html_math_renderer = "mathml"

sphinx_gallery_conf = {
    "examples_dirs": ["../examples/gallery"],
    "gallery_dirs": ["gallery"],
    "image_scrapers": ("matplotlib", "website.figures.figures_of_block"),
    "filename_pattern": r"/\w+\.py",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "show_signature": False,
    "show_memory": False,
    "write_computation_times": False,
    "min_reported_time": 1e9,
    "abort_on_example_error": True,
    "reference_url": {"membrane_rs": None},
    "backreferences_dir": None,
    "copyfile_regex": "",
}

html_theme = "pydata_sphinx_theme"
html_title = f"membrane_rs {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_sidebars = {"extending": []}  # a section of one page, which has nothing to list
html_copy_source = False
html_theme_options = {
    "logo": {"text": "membrane_rs", "image_light": "_static/logo.svg", "image_dark": "_static/logo.svg"},
    "navbar_align": "left",
    "header_links_before_dropdown": 8,
    "show_nav_level": 1,
    "show_toc_level": 2,
    "footer_start": [],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}
html_favicon = "_static/logo.svg"
