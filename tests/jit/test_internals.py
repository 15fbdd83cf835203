"""What is used of the compiler beyond what it documents stands in one module, and in the table of docs/compiler.md."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import layflat

PACKAGE = Path(layflat.__file__).parent
PAGE = PACKAGE.parents[1] / "docs" / "compiler.md"

DOCUMENTED = (
    "numba",
    "numba.cuda",
    "numba.extending",
    "numba.types",
    "numba.core.cgutils",
    "numba.core.event",
    "llvmlite.binding",
    "llvmlite.ir",
)
"""Modules whose names numba's and llvmlite's manuals tell, but for those that begin with an underscore."""


def imported(path: Path) -> Iterator[tuple[str, str]]:
    """Module and name of everything that a file imports of the compiler, at its top or within."""
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield from ((node.module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)


def is_documented(module: str, name: str) -> bool:
    own = module in DOCUMENTED and f"{module}.{name}" != "llvmlite.binding.ffi"
    return (own or f"{module}.{name}" in DOCUMENTED) and not name.startswith("_")


def private() -> dict[str, set[str]]:
    """Files that import each private name, relative to the package."""
    found: dict[str, set[str]] = {}
    for path in PACKAGE.rglob("*.py"):
        for module, name in imported(path):
            if module.split(".")[0] in ("numba", "llvmlite") and not is_documented(module, name):
                found.setdefault(f"{module}.{name}", set()).add(str(path.relative_to(PACKAGE)))
    return found


def told() -> dict[str, set[str]]:
    """Files by private name, as the page's table has them."""
    rows = [line.split("|")[1:-1] for line in PAGE.read_text(encoding="utf-8").split("\n") if line.startswith("| `")]
    names = [
        (re.findall(r"`((?:numba|llvmlite)\.[\w.]+)`", row[0]), set(re.findall(r"`([\w/]+\.py)`", row[1])))
        for row in rows
    ]
    return {name: files for own, files in names for name in own}


def test_private_imports_are_those_of_the_table() -> None:
    assert private() == told()


def test_all_that_can_stand_in_one_module_does() -> None:
    assert {name for name, files in private().items() if files != {"jit/internals.py"}} == set()


def test_private_attributes_are_told() -> None:
    files = [ast.parse(path.read_bytes()) for path in (PACKAGE / "jit").rglob("*.py")]
    nodes = [node for file in files for node in ast.walk(file)]
    own = {node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    used = {node.attr for node in nodes if isinstance(node, ast.Attribute) and node.attr[0] == "_" != node.attr[1]}
    text = PAGE.read_text(encoding="utf-8")
    assert {name for name in used if f"`{name}`" not in text} <= own | made(nodes)


def made(nodes: list[ast.AST]) -> set[str]:
    """Attributes that an object is given as its own."""
    targets = [each for node in nodes if isinstance(node, ast.Assign) for each in node.targets]
    targets += [node.target for node in nodes if isinstance(node, ast.AnnAssign)]
    targets += [each for target in targets if isinstance(target, ast.Tuple) for each in target.elts]
    return {
        each.attr
        for each in targets
        if isinstance(each, ast.Attribute) and isinstance(each.value, ast.Name) and each.value.id == "self"
    }
