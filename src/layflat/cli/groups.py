"""Groups of commands: the commands about a noun, each a verb; and the module in which each command is."""

from typing import Annotated

import typer

from layflat._version import __version__
from layflat.cli.lazy import LazyTyper

COMMANDS = "Commands"  # heading of a group's help
VERBOSE_OPTION = "--verbose"  # option of every command
COMPLETION_VARIABLE = "_LAYFLAT_COMPLETE"  # environment variable by which a shell's script asks for completions

machines = LazyTyper(
    "machine",
    "List, show and check machines and test benches.",
    {COMMANDS: {"list": "describe", "show": "describe", "check": "describe", "schema": "describe"}},
)
joints = LazyTyper(
    "joint", "Size, design and sweep joints.", {COMMANDS: {"size": "design", "design": "design", "sweep": "simulate"}}
)
arms = LazyTyper(
    "arm",
    "Size and view arms; import and export URDF and MJCF.",
    {COMMANDS: {"size": "size_arm", "view": "view", "import": "arm", "export": "arm"}},
)
tasks = LazyTyper(
    "task", "List and show tasks, from which arms are sized.", {COMMANDS: {"list": "size_arm", "show": "size_arm"}}
)
studies = LazyTyper(
    "study", "List, show and run parameter studies.", {COMMANDS: {"list": "study", "show": "study", "run": "study"}}
)
motions = LazyTyper(
    "motion",
    "List, show, plan and learn motions of an arm.",
    {COMMANDS: {"list": "motion", "show": "motion", "plan": "motion", "learn": "learn"}},
)
logs = LazyTyper(
    "log",
    "Check, map, show, convert and repair logs of benches and rigs.",
    {
        COMMANDS: {
            "check": "log",
            "map": "log",
            "info": "recorded",
            "plot": "recorded",
            "export": "recorded",
            "lerobot": "lerobot",
            "repair": "recorded",
        }
    },
)
rigs = LazyTyper(
    "rig",
    "Run a machine on a rig, real or virtual.",
    {COMMANDS: {"run": "rig_run", "check": "rig_trials", "serve": "rig_serve", "faults": "rig_trials"}},
)
cells = LazyTyper(
    "cell",
    "List and show packing cells, and pack in one.",
    {COMMANDS: {"list": "pack", "show": "pack", "pack": "pack"}},
)

app = LazyTyper(
    "layflat",
    "Design, simulate and control robot joints made of layflat hose.",
    {
        "Describe and design": {
            "machine": machines,
            "joint": joints,
            "arm": arms,
            "task": tasks,
            "studio": "pages",
            "build": "build",
            "migrate": "migrate",
        },
        "Simulate": {"simulate": "simulate", "study": studies},
        "Control": {"tune": "tune", "bode": "bode", "motion": motions},
        "Measure": {"excite": "identify", "log": logs, "identify": "identify"},
        "Run a rig": {"rig": rigs, "panel": "pages"},
        "Pack in a cell": {"cell": cells},
        "Run elsewhere": {"export": "export", "foxglove": "foxglove"},
        "Research": {"reproduce": "reproduce", "beyond": "reproduce"},
        "Help": {"docs": "describe", "cache": "cache", "completion": "completion"},
    },
)


def show_version(requested: bool) -> None:
    """Print the version and exit, if it is requested."""
    if requested:
        typer.echo(f"layflat {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=show_version, help="Print the version and exit.")
    ] = False,
    verbose: Annotated[  # `main` takes it from any place in the command line
        bool, typer.Option(VERBOSE_OPTION, help="Say what is compiled, and why.")
    ] = False,
) -> None:
    """Accept the options that precede any command."""
