"""Completion of command lines in a shell: the command that prints its script, and the answer to the script."""

from typing import Annotated

import typer

from layflat.cli.completers import complete_choice
from layflat.cli.groups import COMPLETION_VARIABLE, app
from layflat.errors import InputError

SHELL_NAMES = ("bash", "zsh", "fish")


@app.register("completion", *SHELL_NAMES)
def print_script(
    shell: Annotated[
        str, typer.Argument(metavar="SHELL", help="bash, zsh or fish", autocompletion=complete_choice(*SHELL_NAMES))
    ],
) -> None:
    """Print the script by which a shell completes commands.

    It completes commands, options, and the names of machines, joints, tasks, studies, motions, cells and files. Write
    it to ~/.local/share/bash-completion/completions/layflat for bash, to a file _layflat in a folder of zsh's fpath, or
    to ~/.config/fish/completions/layflat.fish, and start a new shell.
    """
    from typer.completion import get_completion_script  # type: ignore[attr-defined]  # noqa: PLC0415  # typer's own name of it

    if shell not in SHELL_NAMES:
        raise InputError(f"unknown shell {shell!r}", where="SHELL", right="give bash, zsh or fish")
    typer.echo(get_completion_script(prog_name="layflat", complete_var=COMPLETION_VARIABLE, shell=shell))


def answer_shell() -> None:
    """Print the completions that a shell's script asks for by environment variables, and exit."""
    from typer.completion import completion_init  # type: ignore[attr-defined]  # noqa: PLC0415  # typer's own name of it

    completion_init()
    app(prog_name="layflat", complete_var=COMPLETION_VARIABLE)
