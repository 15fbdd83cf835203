"""Rooms state their public names in `__all__`: all are there, and none is missing that others use or pages name."""

import ast
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import pytest

import layflat
from tests.docs.blocks import PAGES, read_blocks

SOURCE = Path(layflat.__file__).parents[1]
EXAMPLES = sorted((SOURCE.parent / "examples").glob("*.py"))


class Used(NamedTuple):
    """Name of a module that another place imports."""

    module: str
    name: str
    by: str  # the module, or "" for a page or an example


def _modules() -> dict[str, ast.Module]:
    paths = {path: path.relative_to(SOURCE).with_suffix("").parts for path in (SOURCE / "layflat").rglob("*.py")}
    return {
        ".".join(parts).removesuffix(".__init__"): ast.parse(path.read_text(encoding="utf-8"))
        for path, parts in paths.items()
    }


MODULES = _modules()


def exported(module: str) -> set[str] | None:
    """Names in the `__all__` of a module; None where it has none."""
    for node in MODULES[module].body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return set(ast.literal_eval(node.value)) if module != "layflat" else set(layflat.__all__)
    return None


EXPORTED = {module: names for module in MODULES if (names := exported(module)) is not None}


def imports(tree: ast.AST, by: str) -> Iterator[Used]:
    """Names that a piece of code imports from modules of the package, without modules."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module in MODULES:
            for alias in node.names:
                if f"{node.module}.{alias.name}" not in MODULES:
                    yield Used(node.module, alias.name, by)


def room(module: str) -> str:
    return ".".join(module.split(".")[:2])


IN_PAGES = [
    *(used for page in PAGES for block in read_blocks(page) if block.language == "python" and not block.reason
      for used in imports(ast.parse(block.text), "")),
    *(used for path in EXAMPLES for used in imports(ast.parse(path.read_text(encoding="utf-8")), "")),
]  # fmt: skip
IN_ROOMS = [
    used for name, tree in MODULES.items() for used in imports(tree, name) if room(used.module) != room(name)
]  # fmt: skip


def is_exported(used: Used) -> bool:
    """Return whether a name is in the `__all__` of its module, or of a package that has it."""
    return any(used.name in names for module, names in EXPORTED.items() if f"{used.module}.".startswith(f"{module}."))


def test_pages_and_examples_name_only_what_is_exported() -> None:
    assert sorted({f"{used.module}.{used.name}" for used in IN_PAGES if not is_exported(used)}) == []


def test_a_package_exports_what_other_rooms_take_from_it() -> None:
    packages = {module for module in MODULES if any(other.startswith(f"{module}.") for other in MODULES)}
    taken = {used for used in IN_ROOMS if used.module in packages and used.name != "__version__"}
    assert sorted({f"{used.module}.{used.name}" for used in taken if not is_exported(used)}) == []


@pytest.mark.parametrize("module", sorted(EXPORTED))
def test_every_name_that_is_exported_is_there(module: str) -> None:
    found = import_module(module)
    assert [name for name in sorted(EXPORTED[module]) if not hasattr(found, name)] == []
    assert len(found.__all__) == len(set(found.__all__))
