"""Command about the documentation, which a wheel carries along: docs."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from layflat.cli.app import app, print_table
from layflat.errors import InputError


@app.command()
def docs(
    page: Annotated[str, typer.Argument(metavar="[PAGE]", help="page to print; default: a list of all")] = "",
) -> None:
    """List the pages of the documentation, or print one of them."""
    from layflat.description.hints import did_you_mean  # noqa: PLC0415

    folder = docs_folder()
    pages = {path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(folder.rglob("*.md"))}
    if not page:
        print_table(["page", "title"], [[name, page_title(path)] for name, path in pages.items()])
        typer.echo(f"\nprint one: layflat docs PAGE; with their pictures they are in\n{folder}")
        return
    paths = {Path(name).name: path for name, path in pages.items()} | pages
    path = paths.get(page.removesuffix(".md"))
    if path is None:
        raise InputError(f"there is no page {page!r}", where="PAGE", right=did_you_mean(page, paths, "pages are {}"))
    print_page(path.read_text(encoding="utf-8"))


def docs_folder() -> Path:
    """Return the folder of the pages: inside the package as a wheel installs it, beside it in a clone."""
    package = Path(__file__).parents[1]
    return next(folder for folder in (package / "docs", package.parents[1] / "docs") if folder.is_dir())


def page_title(path: Path) -> str:
    """Return the heading of a page."""
    return path.read_text(encoding="utf-8").partition("\n")[0].lstrip("# ")


def print_page(text: str) -> None:
    """Print a page: laid out in a terminal, as it is written elsewhere."""
    if not sys.stdout.isatty():
        typer.echo(text, nl=False)
        return
    from rich.console import Console  # noqa: PLC0415
    from rich.markdown import Markdown  # noqa: PLC0415

    console = Console()
    with console.pager(styles=True):
        console.print(Markdown(text))
