"""Settings of Sphinx for the documentation site; `build_site.py` calls it on the staged pages."""

from __future__ import annotations

import re
from importlib.metadata import version as version_of
from typing import Any

project = "CBPT"
author = "the CBPT authors"
release = version_of("cbpt")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_heading_anchors = 4  # the anchors that a forge gives to headings
templates_path: list[str] = []
default_role = "code"  # docstrings write `name`, as Markdown does
nitpicky = False  # types of numpy and of the standard library have no page here

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
autodoc_type_aliases = {name: name for name in ("ArrayLike", "Floats", "Progress", "Report")}
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 80
napoleon_google_docstring = False
napoleon_use_rtype = False

html_theme = "furo"
html_title = f"CBPT {release}"
html_static_path = ["_static"]
html_css_files = ["cbpt.css"]
html_extra_path = ["../reference/answer.schema.json"]  # to the top of the site
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
highlight_language = "text"


def plain_aliases(*event: Any) -> tuple[str | None, str | None]:
    """A signature with aliases by their names alone; Sphinx hands it over last, with the result."""
    signature, returns = event[-2:]

    def plain(text: str | None) -> str | None:
        return text and re.sub(r"TypeAliasForwardRef\('(\w+)'\)", r"\1", text)

    return plain(signature), plain(returns)


def setup(app: Any) -> None:
    app.connect("autodoc-process-signature", plain_aliases)
