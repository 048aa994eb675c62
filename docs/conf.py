"""Configuration of the documentation site: `make docs` builds it into out/docs."""

import sys
from pathlib import Path

import numpy.typing as npt
from sphinx.util.typing import stringify_annotation

DOCS = Path(__file__).parent
sys.path[:0] = [str(DOCS / "_ext"), str(DOCS.parent / "src")]

import urushi  # noqa: E402 (found by the path above)

project = "Urushi"
author = "The Urushi developers"
copyright = author
version = release = urushi.__version__

extensions = [
    "mathml",
    "myst_parser",
    "notebooks",
    "plugin_docs",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
]
exclude_patterns = ["cookbook/stage"]
nitpicky = True
nitpick_ignore_regex = [
    ("py:.*", r"(numpy|npt|np|os|mi|collections|urushi\.\w+)\..*|ArrayLike|Model|Weights")
]
suppress_warnings = ["myst.xref_missing_file"]  # links to files of the repository

default_role = "code"
highlight_language = "none"
myst_enable_extensions = ["attrs_block", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
myst_links_external_new_tab = False

autodoc_member_order = "bysource"
python_maximum_signature_line_length = 88
napoleon_numpy_docstring = False
napoleon_use_rtype = False
napoleon_custom_sections = [("Warns", "returns_style")]

html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"Urushi {release}"
html_static_path = ["_static"]
html_css_files = ["urushi.css"]
html_theme_options = {
    "light_css_variables": {
        "color-brand-primary": "#9c1c12",
        "color-brand-content": "#9c1c12",
        "color-brand-visited": "#7a3b36",
    },
    "dark_css_variables": {
        "color-brand-primary": "#f08a6c",
        "color-brand-content": "#f08a6c",
        "color-brand-visited": "#c98d7c",
    },
}

ARRAY_LIKE = stringify_annotation(npt.ArrayLike, "smart")


def short_types(app, what, name, obj, options, signature, result):
    """The signature that autodoc shows, with NumPy's name of what `ArrayLike` stands for."""
    if signature is None:
        return None
    named = signature.replace(ARRAY_LIKE, "~numpy.typing.ArrayLike")
    return named.replace("<factory>", "..."), result


def setup(app):
    app.connect("autodoc-process-signature", short_types)
