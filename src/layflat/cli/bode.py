"""Command that compares a machine's linear model with the simulated plant, and prints its margins."""

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import in_background
from layflat.cli.common import MachineName, Out, naming_options, print_table
from layflat.cli.completers import complete_choice
from layflat.cli.groups import app
from layflat.cli.moves import parse_row

if TYPE_CHECKING:
    from layflat.linear.comparison import BodeComparison


@app.register("bode", "paper-arm-tracking --joints held", 'paper-arm-tracking --speed "5 deg/s"')
def draw_bode(
    machine: MachineName,
    joints: Annotated[
        str,
        typer.Option(
            help='"sliding" or "held", or those of some joints, such as "elbow=sliding"; others are held then',
            autocompletion=complete_choice("sliding", "held"),
        ),
    ] = "sliding",
    configuration: Annotated[str, typer.Option(help='angles of the joints, such as "20 deg, 0 deg"')] = "0 deg",
    speed: Annotated[
        str | None, typer.Option(help="of joints that slide  [default: 0.3 deg/s, or above the dither's ripple]")
    ] = None,
    pressures: Annotated[
        str | None,
        typer.Option(
            help='absolute, of hoses A and B: "3.5 bar:3 bar" or "elbow=4 bar:3 bar"  [default: that carry the load]'
        ),
    ] = None,
    out: Out = Path("build/bode"),
) -> None:
    """Draw a machine's response to its valves and its loops.

    Prints the errors of the linear model and the margins of the control law, its loop opened at a valve's input. Needs
    the extra `control`. Writes NAME-bode.png and NAME-bode.csv, after the machine's name.
    """
    from layflat.extras import require  # noqa: PLC0415

    require("control", where="bode")
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.linear import linearize  # noqa: PLC0415
    from layflat.linear.comparison import BodeComparison  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.plot.style import save_figure  # noqa: PLC0415

    described = load(machine)
    picture, table = f"{described.name}-bode.png", f"{described.name}-bode.csv"
    check_folder(out, picture, table)
    names = list(described.joints)
    with naming_options({name: f"--{name}" for name in ("joints", "configuration", "speed", "pressures")}):
        model = linearize(
            described, joints={name: str(state) for name, state in parse_row(joints, names, "--joints").items()},
            configuration=parse_row(configuration, names, "--configuration"),
            pressures=None if pressures is None else _parse_pairs(pressures, names), speed=speed,
        )  # fmt: skip
        comparison = BodeComparison(model)
        in_background(lambda: comparison.margins, "closing the loops")
        errors = in_background(comparison.errors, "measuring the plant")
    _print_comparison(comparison, errors, f"{described.name}, {joints}")
    typer.echo(f"wrote {save_figure(comparison.plot(), out / picture)}")
    typer.echo(f"wrote {comparison.save_table(out / table)}")


def _parse_pairs(text: str, names: list[str]) -> dict[str, tuple[str, str]]:
    """Return pressures of hoses A and B by joint, of the option --pressures; raise InputError if they are no pairs."""
    from layflat.errors import InputError  # noqa: PLC0415

    pairs = {}
    for name, pair in parse_row(text, names, "--pressures").items():
        a, colon, b = str(pair).partition(":")
        if not colon:
            right = 'give those of hoses A and B, such as "3.5 bar:3 bar"'
            raise InputError(f"{pair!r} is no pair", where="--pressures", right=right)
        pairs[name] = a.strip(), b.strip()
    return pairs


def _print_comparison(comparison: "BodeComparison", errors: "dict[str, tuple[float, float]]", title: str) -> None:
    """Print the errors of the linear model and the margins of the loops, a row for each joint."""
    columns = ["joint", *(["gain error (%)", "phase error (deg)"] if errors else [])]
    columns += ["gain margin", "phase margin (deg)", "crossover (Hz)"] if comparison.margins else []
    rows = []
    for joint in comparison.joints:
        row = [joint]
        if errors:
            row += [f"{100.0 * errors[joint][0]:.1f}", f"{errors[joint][1]:.1f}"]
        if comparison.margins:
            margins = comparison.margins[joint]
            numbers = () if margins is None else (margins.gain, margins.phase, margins.crossover)
            texts = [f"{number:.3g}" if isfinite(number) else "-" for number in numbers]
            closed = comparison.closes_loop(joint)
            row += (texts or ["does not settle", "", ""]) if closed else ["no loop: the valve is centred", "", ""]
        rows.append(row)
    print_table(columns, rows, title)
    if comparison.growth:
        grown = f"deviations grow by e in {1.0 / comparison.growth:.2g} s"
        typer.echo(f"the plant is not measured: joints stick and slip, or fall, at this speed: {grown}")
