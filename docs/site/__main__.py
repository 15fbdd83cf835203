"""Build the documentation as a site: `make docs`, or `python -m docs.site [FOLDER]`."""

import argparse
import shutil
import sys
from pathlib import Path

from sphinx.cmd.build import main as build

from docs.site.accessibility import mend_pages
from docs.site.commands import command_reference
from docs.site.descriptions import description_reference
from docs.site.interface import interface_reference
from docs.site.pages import ROOT, SECTIONS, SIMULATOR_NAME, copy_pages, index
from layflat.export.web.page import write_simulator

REFERENCES = {
    "interface.md": interface_reference,
    "commands.md": command_reference,
    "descriptions.md": description_reference,
}

SIMULATOR_MACHINES = ("paper-arm", "paper-arm-fast", "paper-small-joint", "paper-small-joint-fast")
"""Machines of the page that simulates in the browser; with the larger valve or not, they share their code."""


def write_sources(source: Path, *, has_simulator: bool) -> None:
    """Write all that Sphinx reads into an empty folder: copies of the pages, references, and the index."""
    copy_pages(source)
    (source / "reference").mkdir()
    for name, reference in REFERENCES.items():
        (source / "reference" / name).write_text(reference(), encoding="utf-8")
    (source / "index.md").write_text(index(SECTIONS, has_simulator=has_simulator), encoding="utf-8")


def build_site(folder: Path, *, run_examples: bool = True) -> int:
    """Build the site in a folder, in place of its content; return the status of Sphinx, which takes no warning."""
    source = folder.parent / f"{folder.name}-sources"
    for path in (source, folder):
        shutil.rmtree(path, ignore_errors=True)
    source.mkdir(parents=True)
    write_sources(source, has_simulator=run_examples)
    settings = str(Path(__file__).parent)
    gallery = f"plot_gallery={int(run_examples)}"
    options = ["-q", "-W", "--keep-going", "-j", "2", "-b", "html", "-c", settings, "-D", gallery]
    status = int(build([*options, str(source), str(folder)]))
    mend_pages(folder)
    if run_examples:
        write_simulator(folder / SIMULATOR_NAME, SIMULATOR_MACHINES)
    return status


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT / "build" / "docs")
    parser.add_argument("--no-run", action="store_true", help="leave out what takes long")
    arguments = parser.parse_args()
    sys.exit(build_site(arguments.folder, run_examples=not arguments.no_run))
