"""Command that moves a rig."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import COMPILING_TEXT, busy
from layflat.cli.common import MachineName, Out, naming_options, print_table
from layflat.cli.foxglove import FoxglovePort, showing_in_foxglove
from layflat.cli.groups import rigs
from layflat.cli.moves import parse_steps, print_missed, print_moves
from layflat.cli.rig import FAULT_EXIT, INTERRUPT_EXIT, Address, driver_at, stopping
from layflat.errors import InputError

if TYPE_CHECKING:
    import xarray

    from layflat.machine import Machine
    from layflat.rig.plan import DemandPlan, EarlyEndError, PlanRunner
    from layflat.rig.recorded import RecordedSession
    from layflat.rig.session import RigSnapshot
    from layflat.sim.metrics import MoveMetrics

MOVE_DELAY = 0.1  # of a move without a time after the soft start, s: the joints are stationary before it
FINAL_DURATION = 3.0  # from the last move to the end, where no duration is given, s
MAX_LISTED_EVENTS = 20  # events that are listed; `layflat log info` lists all
MAX_STOP_TIME = 8.0  # of a controlled stop, on top of the time in which hoses empty, s


@rigs.register(
    "run",
    'paper-arm --driver simulated --demand "20 deg"',
    "mine.toml --driver modbus://10.0.0.5:502 --demand tour.csv",
)
def run(
    machine: MachineName,
    driver: Address,
    demand: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FILE|TEXT",
            help='file of demands over time, or "40 deg", "40 deg, 20 deg" or "large=40 deg", with "@ 2 s" for later; '
            "repeatable; default: joints are held",
        ),
    ] = None,
    duration: Annotated[
        str | None, typer.Option(help="from the end of the soft start; default: 3 s after the last move")
    ] = None,
    foxglove: FoxglovePort = None,
    out: Out = Path("build/rig"),
) -> None:
    """Run a machine on a rig: soft start, moves, controlled stop.

    Writes a log and a figure, and prints metrics. Ctrl-C is a controlled stop. Exit status 3 if a fault ended the run.
    """
    from layflat import extras  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.rig.abilities import vent_time  # noqa: PLC0415
    from layflat.rig.plan import EarlyEndError, PlanRunner  # noqa: PLC0415
    from layflat.rig.recorded import RecordedSession  # noqa: PLC0415
    from layflat.rig.system import require_posix  # noqa: PLC0415

    require_posix("rig run")
    extras.require("rig", "mcap", "mcap_ros2", where="rig run")
    described = load(machine)
    factory, name = driver_at(driver, described)
    plan_from = _plans(described, demand or [], duration)
    check_folder(out)
    early: EarlyEndError | None = None
    with stopping() as stopped, showing_in_foxglove(described, foxglove) as show:
        with busy(f"connecting to {driver} {COMPILING_TEXT}"):
            rig = RecordedSession.in_folder(described, factory, name, out, f"{described.name}-rig")
        show(rig.session.snapshot)
        with rig, _status(rig):
            performance = PlanRunner(rig, stopped)
            try:
                performance.follow(plan_from(performance.start_air()))
            except EarlyEndError as error:
                early = error
            rig.session.end()
            rig.session.process.join(MAX_STOP_TIME + vent_time(described))
    followed = demand[0] if demand and _is_file(demand[0]) else None
    _report(rig, performance, followed)
    if early is not None:
        typer.echo(f"layflat: the run ended early: {early}", err=True)
        raise typer.Exit(FAULT_EXIT if early.fault else INTERRUPT_EXIT)
    if not rig.place.exists():
        raise typer.Exit(FAULT_EXIT)


def _is_file(text: str) -> bool:
    return Path(text).suffix.lower() == ".csv" or Path(text).is_file()


def _plans(machine: Machine, demand: list[str], duration: str | None) -> Callable[[list[float]], DemandPlan]:
    """Return a function that makes the plan from the angles at which joints are held (rad); all of it is checked now.

    Raises:
        InputError: a demand makes no sense, or lies outside the stroke.
    """
    import numpy as np  # noqa: PLC0415

    from layflat.description import units as u  # noqa: PLC0415
    from layflat.motion.signal_rows import read_steps  # noqa: PLC0415
    from layflat.motion.signal_values import SignalKind  # noqa: PLC0415
    from layflat.rig.plan import DemandPlan, check_plan  # noqa: PLC0415

    lasts = u.quantity(duration, u.TIME, "--duration") if duration else None
    if lasts is not None and lasts <= 0.0:
        raise InputError(f"{duration!r} is not a time to run", where="--duration", right='give a time such as "3 s"')
    file = next((text for text in demand if _is_file(text)), None)
    if file is not None and (len(demand) > 1 or duration):
        what = "cannot be combined with other demands or --duration"
        raise InputError(what, where=f"--demand {file}", right="leave them out")

    followed = _from_file(machine, Path(file)) if file is not None else None

    names, where = list(machine.joints), "--demand" if file is None else f"--demand {file}"
    steps = [] if followed is not None else parse_steps(demand, names, where)
    if not steps or steps[0][0] > 0.0:
        steps = [(0.0, {}), *steps]

    def plan(held: list[float]) -> DemandPlan:
        """Return the plan from the angles at which joints are held, rad."""
        if followed is not None:
            return followed
        times, rows = read_steps(steps, SignalKind(where, u.ANGLE, names), np.array(held))
        lead = 0.0 if rows[0].tolist() == held else min([MOVE_DELAY, *times[1:2].tolist()])
        return DemandPlan(
            [lead, *times[1:].tolist()], rows.tolist(), times[-1] + FINAL_DURATION if lasts is None else lasts
        )

    with naming_options({f"{where}: duration": "--duration"}):
        check_plan(machine, plan([0.0] * len(names)), where)
    return plan


def _from_file(machine: Machine, path: Path) -> DemandPlan:
    """Return the plan of a demand file, a row each control cycle; missing velocities or accelerations are derived."""
    from layflat.motion.demand_file import read_demand  # noqa: PLC0415
    from layflat.motion.trajectory import derived_rates  # noqa: PLC0415
    from layflat.rig.plan import DemandPlan, check_accelerations  # noqa: PLC0415

    cycle = machine.cycle
    angles, velocities, accelerations = read_demand(machine, path, cycle)
    if accelerations is not None:
        check_accelerations(machine, accelerations, f"--demand {path}")
    if velocities is None or accelerations is None:
        velocities, accelerations = derived_rates(angles, cycle)
    times = [k * cycle for k in range(len(angles))]
    return DemandPlan(times, angles.tolist(), len(angles) * cycle, velocities.tolist(), accelerations.tolist())


@contextmanager
def _status(rig: RecordedSession) -> Iterator[None]:
    """Show the rig's state in a line on a terminal, updated ten times a second."""
    from rich.console import Console  # noqa: PLC0415
    from rich.live import Live  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    def line() -> Text:
        """Return the line of the loop's last cycle, red in a fault, with a warning if nothing is recorded."""
        try:
            shot = rig.session.snapshot()
        except ValueError:  # the memory was closed meanwhile
            shot = None
        text = "waiting for the loop" if shot is None else status_line(shot, list(rig.machine.joints))
        style = "bold red" if shot is not None and shot.fault else ""
        return Text(text if rig.is_recording else f"NOT RECORDED  {text}", style=style)

    console = Console(stderr=True)
    if not console.is_terminal:
        yield
        return
    with Live(get_renderable=line, console=console, refresh_per_second=10, transient=True):
        yield


def status_line(shot: RigSnapshot, joints: list[str]) -> str:
    """Return one line of state, time, fault, angles / demands (deg), differential pressures, supply (bar), lateness."""
    parts = [f"{shot.state.name.lower():8s}", f"{shot['time']:6.1f} s"]
    if shot.fault:
        parts.insert(1, f"FAULT {shot.fault_text}")
    signals = [list(shot[name]) for name in ("averaged_angle", "demand", "averaged_pressure")]
    for name, angle, demand, pressure in zip(joints, *signals, strict=True):
        parts.append(f"{name} {57.29578 * angle:.1f}/{57.29578 * demand:.1f} deg {pressure / 1e5:+.1f} bar")
    return "  ".join([*parts, f"supply {shot['supply'] / 1e5:.1f} bar", f"late {1e6 * shot['lateness']:.0f} us"])


def _report(rig: RecordedSession, performance: PlanRunner, followed: str | None) -> None:
    """Print metrics, events and messages, write the figure beside the log, and print the paths of both.

    `followed` is the file of demands, against which errors are measured in place of moves.
    """
    from layflat.plot.runs import run_figure  # noqa: PLC0415
    from layflat.plot.style import save_figure  # noqa: PLC0415
    from layflat.rig.recorder.run import read_run  # noqa: PLC0415
    from layflat.sim.metrics import air_used  # noqa: PLC0415

    if rig.place.exists():
        with busy("reading the log"):
            log = read_run(rig.place)
        if performance.sending_times and followed:
            part = log.sel(time=slice(performance.sending_times[0], performance.ended))
            print_missed(part, Path(followed).name)
        elif performance.sending_times:
            print_moves(_moves(log, performance), rig.machine.name)
        if "air_taken" in log:
            typer.echo(f"air: about {air_used(log):.1f} normal litres")
        _print_events(log)
    for line in rig.session.messages:
        typer.echo(line)
    if rig.place.exists():
        typer.echo(f"wrote {rig.place}")
        typer.echo(f"wrote {save_figure(run_figure(log), rig.place.with_suffix('.png'))}")
    elif rig.part is not None:
        typer.echo(f"{rig.part}: was not finished; `layflat log repair {rig.part}` makes it whole", err=True)
    else:
        typer.echo("nothing was recorded", err=True)


def _moves(log: xarray.Dataset, performance: PlanRunner) -> list[tuple[float, MoveMetrics]]:
    """Return start (s) and metrics of every joint for each demand; a demand counts from the cycle that uses it."""
    import numpy as np  # noqa: PLC0415

    from layflat.sim.metrics import measure_move  # noqa: PLC0415

    time, demand = log["time"].to_numpy(), log["demand"].to_numpy()
    changes = time[1:][np.any(np.diff(demand, axis=0) != 0.0, axis=1)]
    ends = [*performance.sending_times[1:], performance.ended]
    moves = []
    for demanded_at, end in zip(performance.sending_times, ends, strict=True):
        after = changes[(changes > demanded_at) & (changes <= end)]
        if len(after):
            since = float(after[0])
            moves += [(round(since, 3), measure_move(log, str(joint), since, end)) for joint in log["joint"].values]
    return moves


def _print_events(log: xarray.Dataset) -> None:
    """Print the first `MAX_LISTED_EVENTS` warnings and errors of a log as a table; nothing without any."""
    events = zip(log["event_time"].values, log["event_level"].values, log["event_text"].values, strict=True)
    rows = [[f"{t:.3f}", {30: "warning", 40: "error"}[int(n)], str(text)] for t, n, text in events if n >= 30]
    if rows:
        left = f", the first {MAX_LISTED_EVENTS} of {len(rows)}" if len(rows) > MAX_LISTED_EVENTS else ""
        print_table(["at (s)", "", "what"], rows[:MAX_LISTED_EVENTS], f"faults and events{left}")
