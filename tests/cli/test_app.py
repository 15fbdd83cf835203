"""What commands share."""

import ast
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

import layflat
from layflat.cli.common import expanded, naming_options
from layflat.errors import InputError
from tests.cli.commands import refused

Name = Annotated[str, typer.Argument(help="of it")]


@dataclass(frozen=True)
class Options:
    size: Annotated[int, typer.Option(min=1, help="how large")]
    colours: Annotated[list[str] | None, typer.Option("--colour", help="repeatable")] = None


def command() -> typer.Typer:
    app = typer.Typer(add_completion=False, rich_markup_mode=None)

    @app.command()
    @expanded
    def paint(name: Name, options: Options, quick: bool = False) -> None:
        """Paint it."""
        typer.echo(f"{name} {options} {quick}")

    return app


def test_the_command_line_is_a_module_too() -> None:
    told = subprocess.run([sys.executable, "-m", "layflat", "--version"], capture_output=True, text=True, check=True)
    assert told.stdout == f"layflat {layflat.__version__}\n"
    wrong = subprocess.run([sys.executable, "-m", "layflat", "simulat"], capture_output=True, text=True, check=False)
    assert (wrong.returncode, wrong.stderr.count("\n")) == (2, 1)


def test_a_group_of_options_stands_among_the_others() -> None:
    done = CliRunner().invoke(command(), ["it", "--size", "2", "--colour", "red", "--colour", "blue", "--quick"])
    assert done.output == "it Options(size=2, colours=['red', 'blue']) True\n"
    assert CliRunner().invoke(command(), ["it", "--size", "3"]).output == "it Options(size=3, colours=None) False\n"
    assert CliRunner().invoke(command(), ["it"]).exit_code == 2, "what has no default has to be given"
    assert CliRunner().invoke(command(), ["it", "--size", "0"]).exit_code == 2
    text = CliRunner().invoke(command(), ["--help"]).output
    assert "Paint it." in text
    assert text.index("--size") < text.index("--colour") < text.index("--quick")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("simulate paper-arm --duration 1s --duration 2s", "'--duration': is given twice; give it once"),
        ("simulate paper-arm -o one --out two", "'--out' / '-o': is given twice"),
        ("rig run paper-arm --driver simulated --driver=serial://x", "'--driver': is given twice"),
        ("arm import arm.urdf --name one --name two", "'--name': is given twice"),
        ("log map log.csv -o one -o two", "is given twice"),
        ("simulate paper-arm --out=", "is empty; leave it out, or give a value"),
        ("joint sweep paper-arm --joint=", "'--joint': is empty"),
        ("simulate paper-arm --move=", "'--move': is empty"),
        ("rig run paper-arm --driver=", "'--driver': is empty"),
    ],
)
def test_an_option_that_has_one_value_is_given_once_and_not_empty(words: str, said: str) -> None:
    assert said in refused(*words.split())


OPTIONS = {"to": "--to", "stroke": "--stroke", "meshes=False": "--no-meshes", "task: volume": "--volume"}


@pytest.mark.parametrize(
    ("error", "named"),
    [
        (InputError("is wrong", where="to"), "--to: is wrong"),
        (InputError("is wrong", where="to 3"), "--to 3: is wrong"),
        (InputError("is wrong", where="task: volume.low.0"), "--volume.low.0: is wrong"),
        (InputError("is wrong", where="arm.urdf", right="give `to='hand'`, or `to='a hand'`"),
         "arm.urdf: is wrong; give --to hand, or --to 'a hand'"),
        (InputError("is wrong", right="leave meshes out: `meshes=False`, or limit `stroke`"),
         "is wrong; leave meshes out: --no-meshes, or limit --stroke"),
        (InputError("is wrong", where="to.toml: to", right="see `layflat docs`, or `other=1`"),
         "to.toml: to: is wrong; see `layflat docs`, or `other=1`"),
    ],
)  # fmt: skip
def test_a_command_names_its_options_in_place_of_arguments(error: InputError, named: str) -> None:
    with pytest.raises(InputError) as caught, naming_options(OPTIONS):
        raise error
    assert str(caught.value) == named


OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
COMMAND_LINES = {
    "outputs.py",
    "extras.py",
    "export/boards.py",
    "export/fmu/libraries.py",
    "tune/tuning.py",
}  # what is forced; lines of pip; options of C compilers; the line that repeats a search


def test_messages_of_the_library_name_no_option() -> None:
    package = Path(layflat.__file__).parent
    for path in sorted(package.rglob("*.py")):
        place = path.relative_to(package)
        if place.parts[0] == "cli" or place.as_posix() in COMMAND_LINES:
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
        docs = {ast.get_docstring(node, clean=False) for node in ast.walk(tree) if isinstance(node, documented)}
        texts = {n.value for n in ast.walk(tree) if isinstance(n, ast.Constant) and isinstance(n.value, str)} - docs
        assert [text for text in texts if OPTION.search(text)] == [], place
