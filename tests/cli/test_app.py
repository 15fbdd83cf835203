"""What commands share."""

from dataclasses import dataclass
from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from layflat.cli.app import expanded
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
        ("loop paper-arm --joint=", "'--joint': is empty"),
        ("simulate paper-arm --move=", "'--move': is empty"),
        ("rig run paper-arm --driver=", "'--driver': is empty"),
    ],
)
def test_an_option_that_has_one_value_is_given_once_and_not_empty(words: str, said: str) -> None:
    assert said in refused(*words.split())
