"""Completers of arguments and options: names of built-in descriptions and of files, joints of a machine, choices.

They are called at each press of the Tab key, so they read names of files, and nothing heavy is imported.
"""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

PACKAGE_FOLDER = Path(__file__).parents[1]
BUILTIN_FOLDERS = {
    "machine": "machine/builtin",
    "bench": "machine/builtin/benches",
    "task": "design/arm/builtin",
    "study": "study/builtin",
    "motion": "motion/builtin",
    "cell": "cell/file/builtin",
}
"""Folder of the built-in descriptions of each noun."""

Completer = Callable[[str], list[str]]


def complete_choice(*choices: str) -> Completer:
    """Return a completer of fixed words."""

    def complete(incomplete: str) -> list[str]:
        return _begin_with(incomplete, choices)

    return complete


def complete_name(*nouns: str, files: bool = True) -> Completer:
    """Return a completer of built-in names, and of description files in the current folder.

    Args:
        nouns: kinds of descriptions, keys of `BUILTIN_FOLDERS`.
        files: whether the argument may be a file, too.
    """

    def complete(incomplete: str) -> list[str]:
        """Return the names and files that begin with a text."""
        folders = [PACKAGE_FOLDER / BUILTIN_FOLDERS[noun] for noun in nouns]
        names = [name for folder in folders for name in sorted(path.stem for path in folder.glob("*.toml"))]
        here = sorted(path.name for path in Path().glob("*.toml")) if files else []
        return _begin_with(incomplete, [*names, *here])

    return complete


def complete_joint(ctx: Any, incomplete: str) -> list[str]:
    """Return the joints of the machine on the command line that begin with a text."""
    from layflat.errors import LayflatError  # noqa: PLC0415
    from layflat.machine.loader import tables  # noqa: PLC0415

    typed = ctx.params.get("machine") or next(iter(ctx.args), "")  # it stands there until the option has its value
    try:
        plain, _ = tables(typed)
    except LayflatError:
        return []
    joints = plain.get("joint", {})
    return _begin_with(incomplete, joints if isinstance(joints, dict) else ())


def complete_target(incomplete: str) -> list[str]:
    """Return the targets of an export that begin with a text."""
    from layflat.export import TARGET_WRITERS  # noqa: PLC0415

    return _begin_with(incomplete, TARGET_WRITERS)


def complete_page(incomplete: str) -> list[str]:
    """Return the pages of the documentation that begin with a text."""
    folder = docs_folder()
    pages = sorted(path.relative_to(folder).with_suffix("").as_posix() for path in folder.rglob("*.md"))
    return _begin_with(incomplete, pages)


def docs_folder() -> Path:
    """Return the folder of the pages: inside the package as a wheel installs it, beside it in a clone."""
    return next(folder for folder in (PACKAGE_FOLDER / "docs", PACKAGE_FOLDER.parents[1] / "docs") if folder.is_dir())


def _begin_with(incomplete: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]
