"""Settings of Sphinx, by its names."""

import re

from pydantic import BaseModel

from docs.site.gallery import GALLERY
from layflat import __version__

project = "layflat"
author = "The layflat team"
release = __version__
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
]
html_theme = "furo"
html_title = f"layflat {__version__}"
html_show_sourcelink = False
html_static_path = ["static"]
html_css_files = ["site.css"]
html_logo = html_favicon = "../logo.svg"
sphinx_gallery_conf = GALLERY
exclude_patterns = ["examples/**"]  # read by the gallery, which makes pages of them
default_role = "code"
myst_heading_anchors = 4
myst_enable_extensions = ["fieldlist"]
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
napoleon_google_docstring = True
napoleon_use_ivar = True
python_display_short_literal_types = True
add_module_names = False
copybutton_exclude = ".linenos, .gp, .go"
# Types of NumPy and of xarray are described elsewhere; nothing is fetched from there.
nitpicky = False
NO_OPERATION = re.compile(r"<function <lambda>>")  # default of a callback
MARKUP = re.compile(r"(`[^`]*`)|([*|])|(\w)_(?!\w)")


def escaped(line: str) -> str:
    """Return a line of a docstring in which only backticks are markup."""
    return MARKUP.sub(lambda match: match[1] or (f"\\{match[2]}" if match[2] else f"{match[3]}\\_"), line)


def setup(app: object) -> None:
    """Let docstrings be plain text, and models without the signature that they share."""

    def plain(_app: object, _what: str, _name: str, _object: object, _options: object, lines: list[str]) -> None:
        lines[:] = [escaped(line) for line in lines]

    def signature(
        _app: object, _what: str, _name: str, found: object, _options: object, given: str | None, returned: str | None
    ) -> tuple[str, str | None] | None:
        if isinstance(found, type) and issubclass(found, BaseModel):
            return "", ""  # its keys are in the reference of description files
        return None if given is None else (NO_OPERATION.sub("...", given), returned)

    app.connect("autodoc-process-docstring", plain, priority=100)  # type: ignore[attr-defined]
    app.connect("autodoc-process-signature", signature)  # type: ignore[attr-defined]
