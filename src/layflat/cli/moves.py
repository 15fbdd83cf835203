"""Parser of moves in options, with joints and times; and tables of how well demands were followed."""

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import typer

from layflat.cli.common import print_table
from layflat.errors import InputError

if TYPE_CHECKING:
    import xarray

    from layflat.sim.metrics import MoveMetrics

TIP_BANDS = (2.0, 5.0)  # settling bands of the tip, mm

DECIMAL_COMMA = re.compile(r"\s*((?:\w+\s*=\s*)?[-+]?\d+),(\d+)(\s*[^\W\d][^,]*?)\s*")  # "4,5 bar", "large=4,5 deg"

Values = dict[str, str | float]
Steps = list[tuple[float, Values]]


def parse_steps(
    texts: Sequence[str], names: Sequence[str], where: str, *, bare: bool = False, of: str = "joint"
) -> Steps:
    """Return steps (s, values by name) from texts such as "40 deg, 20 deg" and "large=40 deg @ 2 s", by time.

    A step names only what its texts mention; see `motion.signal_rows` for what the others do. A single value is meant
    for all names, unless they are axes.

    Args:
        texts: one or more moves; those without a time are at the start.
        names: names of the joints, or of the axes.
        where: the option, in messages.
        bare: whether values are numbers without unit.
        of: noun for a name; "value" for one that all joints share.

    Raises:
        InputError: naming the option: a text makes no sense, or names something twice at one time.
    """
    steps: dict[float, Values] = {}
    for text in texts:
        time, values = _parse_text(text, names, where, bare, of)
        step = steps.setdefault(time, {})
        twice = next((name for name in values if name in step), None)
        if twice is not None:
            what = f"{twice!r} is given twice at {time:g} s"
            raise InputError(what, where=where, right='give it once, or at another time: "... @ 2 s"')
        step.update(values)
    return sorted(steps.items())


def parse_row(text: str, names: Sequence[str], where: str) -> Values:
    """Return values by name from a text such as "40 deg, 20 deg" or "large=40 deg", without a time.

    Args:
        text: one value for all names, a value for each, or NAME=VALUE pairs.
        names: names of the joints.
        where: option, for messages.

    Raises:
        InputError: naming the option `where`: the text makes no sense, or has a time.
    """
    if "@" in text:
        raise InputError(f"{text!r} has a time", where=where, right="give angles alone: they are those at the start")
    return parse_steps([text], names, where)[0][1]


def _parse_text(text: str, names: Sequence[str], where: str, bare: bool, of: str) -> tuple[float, Values]:
    """Return the time (s) and the values by name of one move, such as "large=20 deg @ 1 s".

    Args:
        text: move as typed; one value without name is for all names, except for axes.
        names: names of the joints or axes.
        where: option, for messages.
        bare: whether values are numbers without unit.
        of: noun of the names in messages: "joint", "axis", or "value" where all joints have the same.

    Raises:
        InputError: unknown names, a wrong number of values, a decimal comma, or a time before the start.
    """
    from layflat.description import units as u  # noqa: PLC0415

    body, at, when = text.partition("@")
    time = u.quantity(when.strip(), u.TIME, where) if at else 0.0
    if time < 0.0:
        raise InputError(f"{when.strip()!r} is before the start", where=where, right='give a time such as "@ 2 s"')
    comma = None if bare else DECIMAL_COMMA.fullmatch(body)
    if comma:
        right = f'write "{comma[1]}.{comma[2]}{comma[3]}"; values of several joints have a unit each'
        raise InputError(f"{text!r} has a comma in its number", where=where, right=right)
    items = [item.strip() for item in body.split(",")]
    if any("=" in item for item in items):
        pairs = [[part.strip() for part in item.partition("=")[::2]] for item in items]
        unknown = [name for name, _ in pairs if name not in names]
        if unknown and of == "value":
            right = "give one value: it is the same for all joints"
            raise InputError(f"{text!r} names a joint", where=where, right=right)
        if unknown:
            plural = "axes" if of == "axis" else "joints"
            raise InputError(f"unknown {of} {unknown[0]!r}", where=where, right=f"{plural} are {', '.join(names)}")
        twice = next((name for i, (name, _) in enumerate(pairs) if name in dict(pairs[:i])), None)
        if twice is not None:
            raise InputError(f"{twice!r} is given twice in {text!r}", where=where, right="give it once")
        return time, {name: _parse_value(value, where, bare) for name, value in pairs}
    if len(items) not in {len(names) if of == "axis" else 1, len(names)}:
        right = "give one" if of == "value" else f"give {len(names)}: {', '.join(names)}"
        raise InputError(f"{text!r} has {len(items)} values", where=where, right=right)
    each = items * len(names) if len(items) == 1 else items
    return time, {name: _parse_value(item, where, bare) for name, item in zip(names, each, strict=True)}


def _parse_value(text: str, where: str, bare: bool) -> str | float:
    """Return a value as a number if it is bare, else its text; raise InputError if it is no number."""
    if not bare:
        return text
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{text!r} is not a number", where=where, right="give a number such as 0.5") from None


def print_moves(moves: "Sequence[tuple[float, MoveMetrics]]", name: str) -> None:
    """Print the metrics of moves, with their start times (s), as a table."""
    rows = [
        [
            f"{since:g}",
            m.joint,
            _format_settling(m.settling),
            *(f"{57.29578 * x:.3f}" for x in (m.overshoot, m.steady_error)),
        ]
        for since, m in moves
    ]
    columns = ["from (s)", "joint", "settling (s)", "overshoot (deg)", "steady error (deg)"]
    print_table(columns, rows, f"{name}: moves, settled within 0.3 deg")


def print_tip_moves(run: "xarray.Dataset", name: str) -> None:
    """Print settling times and final error of the tip for each move, as a table."""
    from layflat.sim.tip_metrics import measure_tip_moves  # noqa: PLC0415

    rows = [
        [f"{since:g}", *map(_format_settling, m.settling), f"{1e3 * m.error:.2f}"]
        for since, m in measure_tip_moves(run, tuple(1e-3 * band for band in TIP_BANDS))
    ]
    within = [f"within {band:g} mm (s)" for band in TIP_BANDS]
    print_table(["from (s)", *within, "at most, at the end (mm)"], rows, f"{name}: tip, from its goal")


def print_tip_missed(run: "xarray.Dataset") -> None:
    """Print the tip's errors against demands that change all the time: from its reference and from its path."""
    from layflat.sim.tip_metrics import measure_path_errors  # noqa: PLC0415

    missed = measure_path_errors(run)
    (behind, max_behind), (beside, max_beside) = missed.tracking, missed.contour
    errors = f"{1e3 * behind:.2f} mm rms, {1e3 * max_behind:.2f} mm at most from where it should be"
    typer.echo(f"tip: {errors}; {1e3 * beside:.2f} mm rms, {1e3 * max_beside:.2f} mm at most from its path")


def print_missed(run: "xarray.Dataset", what: str) -> None:
    """Print the rms error (deg) of each joint against demands that change all the time."""
    missed = 57.29578 * ((run["angle"] - run["demand"]) ** 2).mean("time") ** 0.5
    errors = ", ".join(f"{name} {missed.sel(joint=name).item():.2f} deg" for name in run["joint"].values)
    typer.echo(f"rms error against {what}: {errors}")


def _format_settling(value: float) -> str:
    return f"{value:.3f}" if value < 1e6 else "not settled"
