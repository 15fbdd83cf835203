"""Check of the language of names, docstrings, messages and pages: `python -m lint.language`.

Prints a line for each finding, with what would be right, and exits with 1 if there are any. A line of code with a
comment `# language: REASON` is excepted; the words are in words.toml, and rules of pages in pages.py. Pages under
`pending` there are not checked yet.
"""

import ast
import re
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from lint.findings import Finding, Words
from lint.pages import check_page, find_phrases

ROOT = Path(__file__).parents[1]
SOURCES = ("src", "layflat-ros2/src")
EXCEPTED = re.compile(r"#.*\blanguage: \S")
MIN_PARAMETERS = 3  # of a public function that needs an Args section
SYMBOL_DECORATORS = {"law", "composition", "kernel", "portable_kernel"}  # their modules have a table of symbols
Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass
class Module:
    """Module that is checked: its syntax tree, and the lines that are excepted."""

    path: Path
    text: str
    tree: ast.Module = field(init=False)
    excepted: frozenset[int] = field(init=False)

    def __post_init__(self) -> None:
        """Parse the text."""
        self.tree = ast.parse(self.text)
        lines = enumerate(self.text.splitlines(), start=1)
        self.excepted = frozenset(number for number, line in lines if EXCEPTED.search(line))


def check_module(module: Module, words: Words) -> Iterator[Finding]:
    """Yield the findings of one module, without those that need all modules."""
    found = [*_constants(module, words), *_docstrings(module, words), *_messages(module, words)]
    for node in ast.walk(module.tree):
        if isinstance(node, Function):
            found += _check_names(node, words)
    for function in _outer_functions(module.tree.body):
        found += _arguments(function)
    for line, rule, text in sorted(found):
        if line not in module.excepted:
            yield Finding(module.path, line, rule, text)


Line = tuple[int, str, str]
"""Number of a line, rule and text of a finding."""


def _constants(module: Module, words: Words) -> Iterator[Line]:
    """Yield constants of the module whose name is a single word, except those in `words.constants`."""
    for node in module.tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets:
            for one in target.elts if isinstance(target, ast.Tuple) else [target]:
                name = one.id.strip("_") if isinstance(one, ast.Name) else ""
                if name.isupper() and "_" not in name and name not in words.constants:
                    yield node.lineno, "constant", f"{name} names no quantity; say which, such as MAX_RESTARTS"


def _docstrings(module: Module, words: Words) -> Iterator[Line]:
    """Yield docstrings, also those below constants, that begin with one of `words.first`."""
    for node in ast.walk(module.tree):
        body = getattr(node, "body", [])
        for one in body if isinstance(body, list) else []:
            if isinstance(one, ast.Expr) and isinstance(one.value, ast.Constant) and isinstance(one.value.value, str):
                word = re.match(r"[\s`'\"]*(\w+)", one.value.value)
                if word and word[1].lower() in words.first:
                    yield one.lineno, "docstring", f"begins with {word[1]!r}; use an imperative, or a noun phrase"


def _messages(module: Module, words: Words) -> Iterator[Line]:
    """Yield texts with one of `words.phrases` in calls of names that end in "Error"."""
    for node in ast.walk(module.tree):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id.endswith("Error")):
            continue
        for one in ast.walk(node):
            if isinstance(one, ast.Constant) and isinstance(one.value, str):
                for _, phrase, right in find_phrases(one.value, words.phrases):
                    yield one.lineno, "message", f"{phrase!r}; use {right}"


def _parameters(function: Function) -> list[ast.arg]:
    """Return the parameters of a function, without self, cls, `*` and `**`."""
    arguments = function.args
    return [
        one for one in [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
        if one.arg not in {"self", "cls"}
    ]  # fmt: skip


def _check_names(function: Function, words: Words) -> Iterator[Line]:
    """Yield a function's name if it is one of `words.functions`, and its parameters that are in `words.parameters`."""
    if function.name.strip("_") in words.functions:
        yield function.lineno, "function", f"{function.name} does not say what it computes; use a verb with its object"
    for one in _parameters(function):
        if one.arg in words.parameters:
            yield one.lineno, "parameter", f"{one.arg} does not say what it is; name the thing"


def _outer_functions(body: list[ast.stmt]) -> Iterator[Function]:
    """Yield functions and methods of a module, without those inside other functions."""
    for node in body:
        if isinstance(node, Function):
            yield node
        elif isinstance(node, ast.ClassDef):
            yield from _outer_functions(node.body)


def _decorators(function: Function) -> set[str]:
    """Return all words in the source of a function's decorators."""
    return {word for one in function.decorator_list for word in re.findall(r"\w+", ast.unparse(one))}


def _arguments(function: Function) -> Iterator[Line]:
    """Yield a public function of `MIN_PARAMETERS` or more without an Args section, unless its decorator excepts it."""
    public = not function.name.startswith("_")
    shown = _decorators(function) & (SYMBOL_DECORATORS | {"command", "register", "callback", "overload", "override"})
    described = "Args:" in (ast.get_docstring(function) or "")
    if public and not shown and not described and len(_parameters(function)) >= MIN_PARAMETERS:
        yield function.lineno, "arguments", f"{function.name} has no Args section"


def check_classes(modules: Iterable[Module], words: Words) -> Iterator[Finding]:
    """Yield a finding for each class that shares its name with another one, except names in `words.classes`."""
    homes: dict[str, list[tuple[Module, int]]] = defaultdict(list)
    for module in modules:
        for node in ast.walk(module.tree):
            if isinstance(node, ast.ClassDef) and node.lineno not in module.excepted:
                homes[node.name].append((module, node.lineno))
    for name, places in homes.items():
        if len(places) > 1 and name not in words.classes:
            for module, line in places:
                yield Finding(
                    module.path, line, "class", f"{name} is {len(places)} things; give each a name of its own"
                )


def check_repository(root: Path = ROOT, words: Words | None = None) -> list[Finding]:
    """Return the findings of the package under `src` and of the pages, without those in `words.pending`."""
    words = words or Words.read()
    paths = sorted(path.relative_to(root) for room in SOURCES for path in (root / room).rglob("*.py"))
    modules = [Module(path, (root / path).read_text(encoding="utf-8")) for path in paths]
    found = [one for module in modules for one in check_module(module, words)]
    found += check_classes(modules, words)
    for path in sorted([*(root / "docs").rglob("*.md"), root / "README.md", root / "CONTRIBUTING.md"]):
        found += check_page(path.relative_to(root), path.read_text(encoding="utf-8"), words)
    return [one for one in found if not one.path.as_posix().startswith(words.pending)]


def main() -> int:
    """Print the findings, and return the exit status."""
    found = check_repository()
    for one in found:
        print(one)  # noqa: T201
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
