"""Pages of the site and their order."""

import shutil
from pathlib import Path

ROOT = Path(__file__).parents[2]
SECTIONS = {
    "Begin": ["README", "docs/installation", "docs/index", "docs/commands"],
    "Tutorials": [
        "docs/tutorials/design-a-joint", "docs/tutorials/build-a-joint", "docs/tutorials/simulate-and-tune",
        "docs/tutorials/pack-produce",
    ],
    "Gallery": ["gallery/index"],
    "How-to guides": [
        "docs/python", "docs/studio", "docs/sizing-arms", "docs/arms", "docs/arm-models", "docs/export", "docs/fmu",
        "docs/motion", "docs/gym", "docs/learning", "docs/identification", "docs/logs", "docs/rig", "docs/panel",
        "docs/foxglove", "docs/packing", "docs/building",
        "docs/bridge", "docs/speed", "docs/cell", "docs/cell-vision", "docs/kinds", "docs/browser",
        "firmware/README", "layflat-ros2/README",
    ],
    "Reference": [
        "reference/interface", "reference/commands", "reference/descriptions", "docs/conventions", "docs/rig-faults",
        "docs/rig-wires", "docs/rig-logs", "docs/arm-conformance", "CHANGELOG",
    ],
    "Explanation": [
        "docs/control", "docs/hysteresis", "docs/friction", "docs/lines", "docs/derivations", "docs/derivations-cam",
        "docs/cloud", "docs/results", "docs/cell-plan",
    ],
    "Development": [
        "docs/architecture", "docs/decisions", "docs/compiler", "CONTRIBUTING", "SECURITY", "research/README",
    ],
}  # fmt: skip
"""Pages by section, without their suffix."""
SIMULATOR_NAME = "simulator.html"  # page that simulates in the browser
GENERATED = ("gallery/", "reference/")  # pages that no file in the repository holds


def copy_pages(source: Path) -> None:
    """Copy all pages and examples into a folder, with the files that pages link to, at the same places."""
    for page in [page for pages in SECTIONS.values() for page in pages if not page.startswith(GENERATED)]:
        target = source / f"{page}.md"
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / f"{page}.md", target)
    shutil.copytree(ROOT / "examples", source / "examples", ignore=shutil.ignore_patterns("build", "__pycache__"))
    for pattern in ("*.png", "*.bib"):
        for file in (ROOT / "docs").glob(pattern):
            shutil.copyfile(file, source / "docs" / file.name)


def index(sections: dict[str, list[str]], *, has_simulator: bool) -> str:
    """Return the first page: the README's first lines, and a table of contents for each section.

    Args:
        sections: pages by section.
        has_simulator: whether the site has the page that simulates in the browser.
    """
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    first = readme[: readme.index("From a clone")]
    lists = [
        "```{toctree}\n" + f":caption: {name}\n:maxdepth: 1\n\n" + "\n".join(map(_entry, pages)) + "\n```\n"
        for name, pages in sections.items()
    ]
    link = f'<p><a href="{SIMULATOR_NAME}">Move an arm in the browser</a>: no installation, no server.</p>\n'
    return "\n".join([first, *([link] if has_simulator else []), *lists])


def _entry(page: str) -> str:
    return f"First steps </{page}>" if page == "README" else f"/{page}"
