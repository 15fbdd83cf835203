"""Sources of laws: their syntax trees, comments and docstrings, and the modules and comments of constants."""

import ast
import inspect
import io
import sys
import textwrap
import tokenize
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from layflat.errors import KindError


class LawSource(NamedTuple):
    """Source of a law."""

    tree: ast.FunctionDef
    file: str
    first_line: int
    comments: dict[int, str]  # by the line of the tree that they stand before, or on


@cache
def law_source(function: Callable[..., Any]) -> LawSource:
    """Return the source of a law's function.

    Raises:
        KindError: there is none.
    """
    try:
        lines, first = inspect.getsourcelines(function)
    except (OSError, TypeError):
        raise KindError(
            f"law {function.__name__!r} has no source", where=function.__module__, right="define it in a file"
        ) from None
    text = textwrap.dedent("".join(lines))
    (tree,) = ast.parse(text).body
    if not isinstance(tree, ast.FunctionDef):
        raise KindError(
            f"law {function.__name__!r} is no function", where=function.__module__, right="define it with def"
        )
    file = inspect.getsourcefile(function) or function.__code__.co_filename
    return LawSource(tree, file, first, _comments(text))


def _comments(text: str) -> dict[int, str]:
    """Return comments by the line of code that they belong to: their own, or the one that follows."""
    comments, waiting = dict[int, str](), list[str]()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            said = token.string.lstrip("# ").strip()
            if said.startswith(("noqa", "fmt:", "type:", "language:")):
                continue
            if token.line.lstrip().startswith("#"):
                waiting.append(said)
            else:
                comments[token.start[0]] = said.split("  # noqa")[0]
        elif token.type not in (tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT) and waiting:
            comments[token.start[0]] = " ".join(waiting)
            waiting.clear()
    return comments


def scope(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the names that a function sees from outside, with their values."""
    import builtins  # noqa: PLC0415  # the names alone

    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    return {**vars(builtins), **function.__globals__, **{name: cell.cell_contents for name, cell in cells}}


class NamedConstant(NamedTuple):
    """Constant of a module: its name and module, and the comment behind or below it."""

    name: str
    module: str
    comment: str


def named_constant(module: str, name: str) -> NamedConstant | None:
    """Return the constant that a name stands for in a module, followed through imports; None without a source.

    Args:
        module: name of the module.
        name: name of the constant there.
    """
    tree = _module_tree(module)
    if tree is None:
        return None
    for i, node in enumerate(tree.body):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for alias in node.names:
                if (alias.asname or alias.name) == name:
                    return named_constant(node.module, alias.name)
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        names = {one.id for target in targets for one in ast.walk(target) if isinstance(one, ast.Name)}
        if name in names:
            return NamedConstant(name, module, _constant_comment(module, node, tree.body[i + 1 : i + 2]))
    return None


def _constant_comment(module: str, node: ast.stmt, after: list[ast.stmt]) -> str:
    """Return the comment of an assignment: the string below it, or the comment behind it."""
    if after and isinstance(after[0], ast.Expr) and isinstance(after[0].value, ast.Constant):
        text = after[0].value.value
        if isinstance(text, str):
            return " ".join(inspect.cleandoc(text).split())
    comments = _module_comments(module)
    found = [comments[line] for line in range(node.lineno, (node.end_lineno or node.lineno) + 1) if line in comments]
    return " ".join(found)


@cache
def _module_text(module: str) -> str | None:
    file = getattr(sys.modules.get(module), "__file__", None)
    if file is None or not file.endswith(".py"):
        return None
    return Path(file).read_text(encoding="utf-8")


@cache
def _module_tree(module: str) -> ast.Module | None:
    text = _module_text(module)
    return None if text is None else ast.parse(text)


@cache
def _module_comments(module: str) -> dict[int, str]:
    """Return comments by line, those behind code alone."""
    comments = dict[int, str]()
    for token in tokenize.generate_tokens(io.StringIO(_module_text(module) or "").readline):
        if token.type == tokenize.COMMENT and not token.line.lstrip().startswith("#"):
            said = token.string.lstrip("# ").split("  # ")[0].strip()
            if not said.startswith(("noqa", "fmt:", "type:", "language:")):
                comments[token.start[0]] = said
    return comments
