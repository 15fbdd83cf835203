"""Settings of sphinx-gallery, which runs the examples when the site is built; figures that pyplot does not know."""

from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

EXAMPLES = "examples"  # copies, beside which examples may write
SECTIONS = ("design", "simulate", "ensembles", "control", "motion", "learn", "measure")

GALLERY: dict[str, Any] = {
    "examples_dirs": EXAMPLES,
    "gallery_dirs": "gallery",
    "subsection_order": [f"{EXAMPLES}/{section}" for section in SECTIONS],
    "within_subsection_order": "FileNameSortKey",
    "filename_pattern": r"\.py$",  # all of them are run
    "image_scrapers": ("matplotlib", "docs.site.gallery.scrape_figure"),
    "ignore_repr_types": "Figure",
    "abort_on_example_error": True,
    "first_notebook_cell": "%matplotlib inline",
    "remove_config_comments": True,
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
    "min_reported_time": 1e6,  # s: times of a busy machine tell nothing
}


def scrape_figure(_block: object, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Return the markup for the figure that a block ends with, such as a result's `plot()`; empty without one.

    Args:
        _block: the block of code.
        block_vars: the example's globals, among them the last expression's value; and paths for pictures.
        gallery_conf: settings of the gallery.
    """
    figure = block_vars["example_globals"].get("___")
    if not isinstance(figure, Figure) or getattr(figure, "is_scraped", False):
        return ""
    figure.is_scraped = True  # type: ignore[attr-defined]  # a block without an expression leaves the value of the last
    path = next(block_vars["image_path_iterator"])
    figure.savefig(path)
    caption = figure.texts[-1].get_text() if figure.texts else ""
    return str(figure_rst([path], gallery_conf["src_dir"], caption))
