"""Command that learns a repeated motion."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import steps_bar
from layflat.cli.common import MachineName, Out, Seed, expanded, print_table
from layflat.cli.completers import complete_name
from layflat.cli.groups import motions
from layflat.errors import InputError, StoppedError

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.motion.learning import LearntCorrections

SUFFIX = ".learnt"


USUAL_REPEATS = 5


@dataclass(frozen=True)
class Learning:
    """Options about the source from which a motion is learnt."""

    repeats: Annotated[
        int | None, typer.Option(min=0, max=1000, help=f"to simulate after the first run  [default: {USUAL_REPEATS}]")
    ] = None
    plant: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE",
            help="machine that moves in simulation  [default: the same]",
            autocompletion=complete_name("machine"),
        ),
    ] = None
    log: Annotated[
        Path | None, typer.Option("--from", metavar="LOG", help="learn from a recorded run of the demand instead")
    ] = None
    learnt: Annotated[
        Path | None, typer.Option(metavar="FILE", help="go on from what was learnt  [default with --from: that in DIR]")
    ] = None
    begin: Annotated[bool, typer.Option("--begin", help="only write the demand of the first run")] = False
    seed: Seed = 0

    def refuse_contradictions(self) -> None:
        """Refuse options that would be ignored beside others (InputError: naming them)."""
        if self.begin and (self.log or self.learnt or self.plant):
            raise InputError(
                "cannot be combined with --from, --learnt or --plant", where="--begin", right="leave it out"
            )
        if self.log is not None and self.plant is not None:
            raise InputError("cannot be combined with --from", where="--plant", right="give one or the other")
        if self.repeats is not None and (self.begin or self.log is not None):
            other = "--begin" if self.begin else "--from"
            what = f"has no effect beside {other}, which simulates nothing"
            raise InputError(what, where="--repeats", right="leave it out")


@motions.register(
    "learn", "build/motion/tour-demand.csv paper-arm-fast", "tour-demand.csv paper-arm-fast --from build/rig/run.mcap"
)
@expanded
def learn_motion(
    demand: Annotated[Path, typer.Argument(metavar="DEMAND", help="motion in CSV, as `layflat motion plan` writes it")],
    machine: MachineName,
    options: Learning,
    out: Out = Path("build/learn"),
) -> None:
    """Learn a motion from simulated repeats, or from a log.

    Prints errors by repeat; writes NAME.learnt, the demand to send next as NAME-learnt-demand.csv, and NAME-learnt.png,
    after the name of the motion's file.
    """
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.motion.demand_file import read_demand  # noqa: PLC0415
    from layflat.motion.learning import begin_learning  # noqa: PLC0415
    from layflat.motion.learning.file import read_learnt, write_learnt  # noqa: PLC0415

    options.refuse_contradictions()
    stopped = ""
    described = load(machine)
    learnt = begin_learning(described, read_demand(described, demand, described.cycle))
    name = demand.stem.removesuffix("-demand")
    file = out / f"{name}{SUFFIX}"
    before = options.learnt or (file if options.log is not None else None)
    if before is not None:
        learnt = read_learnt(before, described, learnt.motion)
    continued = before is not None and before.resolve() == file.resolve()
    check_folder(out, *([] if continued else [file.name]), costly=True)
    check_folder(out, f"{name}-learnt-demand.csv", *([] if options.begin else [f"{name}-learnt.png"]))
    if options.log is not None:
        learnt, angles = _logged(learnt, options.log)
        learnt, measured = learnt.learn_from(angles), [angles]
    elif not options.begin:
        learnt, measured, stopped = _simulated(learnt, options)
    if not options.begin:
        _print_repeats(learnt, f"{name}, learnt with {described.name}")
        _draw(learnt, measured, out / f"{name}-learnt.png")
    typer.echo(f"wrote {write_learnt(learnt, file, continued=continued)}")
    _write_demand(learnt, out / f"{name}-learnt-demand.csv", best=options.log is None and not options.begin)
    if stopped:
        raise StoppedError(stopped, file)


def _simulated(learnt: "LearntCorrections", options: Learning) -> "tuple[LearntCorrections, list[Array], str]":
    """Return the corrections of simulated repeats, true angles of each (rad), and the progress if Ctrl-C ended them."""
    from layflat.machine import load  # noqa: PLC0415
    from layflat.sim.repeats import simulated_repeats  # noqa: PLC0415
    from layflat.sim.run import controlling_machine  # noqa: PLC0415

    plant = load(options.plant) if options.plant is not None else learnt.machine
    controlling_machine(plant, learnt.machine)
    count, angles = (USUAL_REPEATS if options.repeats is None else options.repeats) + (0 if learnt.history else 1), []
    with steps_bar("repeats", count) as advance:
        try:
            for done in simulated_repeats(learnt, count, plant=plant, seed=options.seed):
                learnt = done.learnt
                angles.append(done.angles)
                advance(len(angles), now=f"repeat {len(learnt.history) - 1}: {1e3 * learnt.history[-1].rms:.2f} mm rms")
        except KeyboardInterrupt:
            if not angles:
                raise
    return learnt, angles, f"{len(angles)} of {count} repeats" if len(angles) < count else ""


def _logged(learnt: "LearntCorrections", path: Path) -> "tuple[LearntCorrections, Array]":
    """Return the corrections learnt from a log, whose demand counts as the sent one, and its measured angles.

    The log is one of a run of the demand to send next, or of the best so far.

    Raises:
        InputError: the log lacks angles or demands, or is not one of a run of that demand.
    """
    from layflat.identify.logs import read_log  # noqa: PLC0415
    from layflat.motion.learning import align_measurement  # noqa: PLC0415

    machine = learnt.machine
    log = read_log(path, joints=list(machine.joints), cycle=machine.cycle)
    missing = [name for name in ("angle", "demand") if name not in log]
    if missing:
        raise InputError(f"has no {missing[0]} of the joints", where=str(path), right="give the log of a run")
    angle, demands = (log[name].sel(joint=list(machine.joints)).to_numpy() for name in ("angle", "demand"))
    right = "give a run of the demand that `layflat motion learn` wrote last"
    cycles = len(learnt.uncorrected.angles)
    if len(demands) < cycles:
        what = f"lasts {len(demands)} control cycles, and the demand {cycles}"
        raise InputError(what, where=str(path), right=right)
    for sent, demand in ((learnt.sent, learnt.demand()), (learnt.best, learnt.best_demand())):
        measured = align_measurement(demand, demands, angle, machine.cycle)
        if measured is not None:
            return replace(learnt, sent=sent), measured
    raise InputError("is not of a run of the demand to send next", where=str(path), right=right)


def _print_repeats(learnt: "LearntCorrections", title: str) -> None:
    """Print a table of the repeats with the tip's deviations, and the best one's ratio to the first run."""
    rows = [
        [str(k), f"{1e3 * one.rms:.2f}", f"{1e3 * one.max:.2f}", f"{one.arrival:+.3f}", "yes" if one.kept else "no"]
        for k, one in enumerate(learnt.history)
    ]
    columns = ["repeat", "rms along the path (mm)", "at most (mm)", "within 2 mm, from the end (s)", "best so far"]
    print_table(columns, rows, f"{title}: distance of the tip from where it should be, by the sensors")
    best = min((one for one in learnt.history if one.kept), key=lambda one: one.rms)
    typer.echo(f"the best is {best.rms / learnt.history[0].rms:.2f} times the first run")


def _draw(learnt: "LearntCorrections", angles: "list[Array]", path: Path) -> None:
    """Draw the tip's deviation in the first and the best of these repeats, and the corrections; print the file's path.

    Args:
        learnt: corrections after the repeats, with the history of all repeats.
        angles: joint angles of each of the last repeats, of which two are drawn, (cycles, joints), rad.
        path: path of the picture.
    """
    import numpy as np  # noqa: PLC0415

    from layflat.motion.kinematics import tip_position  # noqa: PLC0415
    from layflat.plot.style import save_figure  # noqa: PLC0415
    from layflat.plot.tuning import RepeatErrors, learning_figure  # noqa: PLC0415

    rested, cycle = learnt.uncorrected.angles, learnt.motion.cycle
    time = cycle * (np.arange(len(rested), dtype=np.float64) - learnt.lead_in_cycles)
    numbers = range(len(learnt.history) - len(angles), len(learnt.history))
    best = max((k for k in numbers if learnt.history[k].kept), default=numbers[-1])
    shown = {}
    for k, label in ((numbers[0], f"repeat {numbers[0]}"), (best, f"repeat {best}")):
        apart = tip_position(learnt.machine, angles[k - numbers[0]]) - tip_position(learnt.machine, rested)
        shown["first run" if k == 0 else label] = 1e3 * np.linalg.norm(apart, axis=1)
    added = 1e3 * learnt.corrections.states(learnt.best).angles.T
    history = learnt.history
    repeats = RepeatErrors(
        [1e3 * one.rms for one in history], [1e3 * one.max for one in history], [o.kept for o in history]
    )
    duration = cycle * (len(learnt.motion.angles) - 1)
    figure = learning_figure(time, duration, shown, dict(zip(learnt.machine.joints, added, strict=True)), repeats)
    typer.echo(f"wrote {save_figure(figure, path)}")


def _write_demand(learnt: "LearntCorrections", demand: Path, *, best: bool) -> None:
    """Write the corrected demand, of the best repeat or the next one, and print its path."""
    import numpy as np  # noqa: PLC0415

    from layflat.motion.demand_file import write_demand  # noqa: PLC0415

    q, v, a = learnt.best_demand() if best else learnt.demand()
    time = learnt.motion.cycle * np.arange(len(q), dtype=np.float64)
    typer.echo(f"wrote {write_demand(learnt.machine, time, q, demand, velocity=v, acceleration=a)}")
    typer.echo(f"the motion begins {learnt.filter.lead_in:g} s after the demand")
