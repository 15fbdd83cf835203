"""The command that learns a repeated motion: learn."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import MachineName, Out, Seed, app, expanded, print_table
from layflat.cli.bars import steps_bar
from layflat.errors import InputError, StoppedError

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.motion.learning import Learnt

SUFFIX = ".learnt"


USUAL_REPEATS = 5


@dataclass(frozen=True)
class Learning:
    """Options that say where a motion is learnt from."""

    repeats: Annotated[
        int | None, typer.Option(min=0, max=1000, help=f"to simulate after the first run  [default: {USUAL_REPEATS}]")
    ] = None
    plant: Annotated[
        str | None, typer.Option(metavar="NAME|FILE", help="machine that moves in simulation  [default: the same]")
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


@app.command()
@expanded
def learn(
    demand: Annotated[Path, typer.Argument(metavar="DEMAND", help="motion in CSV, as `layflat motion` writes it")],
    machine: MachineName,
    options: Learning,
    out: Out = Path("build/learn"),
) -> None:
    """Learn a motion that is repeated, from simulated repeats or from the log of a run.

    Prints errors by repeat; writes NAME.learnt, the demand to send next as NAME-learnt-demand.csv, and NAME-learnt.png,
    after the name of the motion's file.
    """
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.motion.demand_file import read_demand  # noqa: PLC0415
    from layflat.motion.learning import begin, read_learnt, write_learnt  # noqa: PLC0415

    options.refuse_contradictions()
    stopped = ""
    described = load(machine)
    learnt = begin(described, read_demand(described, demand, described.cycle))
    name = demand.stem.removesuffix("-demand")
    file = out / f"{name}{SUFFIX}"
    before = options.learnt or (file if options.log is not None else None)
    if before is not None:
        learnt = read_learnt(before, described, learnt.wanted)
    continued = before is not None and before.resolve() == file.resolve()
    check_folder(out, *([] if continued else [file.name]), costly=True)
    check_folder(out, f"{name}-learnt-demand.csv", *([] if options.begin else [f"{name}-learnt.png"]))
    if options.log is not None:
        learnt, angles = _logged(learnt, options.log)
        learnt, measured = learnt.after(angles), [angles]
    elif not options.begin:
        learnt, measured, stopped = _simulated(learnt, options)
    if not options.begin:
        _print_repeats(learnt, f"{name}, learnt with {described.name}")
        _draw(learnt, measured, out / f"{name}-learnt.png")
    typer.echo(f"wrote {write_learnt(learnt, file, continued=continued)}")
    _write_demand(learnt, out / f"{name}-learnt-demand.csv", best=options.log is None and not options.begin)
    if stopped:
        raise StoppedError(stopped, file)


def _simulated(learnt: "Learnt", options: Learning) -> "tuple[Learnt, list[Array], str]":
    """Return what simulated repeats taught, true angles of each, and how far they came where Ctrl-C ended them."""
    from layflat.machine import load  # noqa: PLC0415
    from layflat.sim.repeats import simulated_repeats  # noqa: PLC0415
    from layflat.sim.run import driver_of  # noqa: PLC0415

    plant = load(options.plant) if options.plant is not None else learnt.machine
    driver_of(plant, learnt.machine)
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


def _logged(learnt: "Learnt", path: Path) -> "tuple[Learnt, Array]":
    """Return what was learnt, with the demand that a log is of as the one that was sent, and measured angles of it.

    The log is one of a run of the demand to send next, or of the best so far.

    Raises:
        InputError: the log lacks angles or demands, or is not one of a run of that demand.
    """
    from layflat.identify.logs import read_log  # noqa: PLC0415
    from layflat.motion.learning.matching import measured_during  # noqa: PLC0415

    machine = learnt.machine
    log = read_log(path, joints=list(machine.joints), cycle=machine.cycle)
    missing = [name for name in ("angle", "demand") if name not in log]
    if missing:
        raise InputError(f"has no {missing[0]} of the joints", where=str(path), right="give the log of a run")
    angle, asked = (log[name].sel(joint=list(machine.joints)).to_numpy() for name in ("angle", "demand"))
    right = "give a run of the demand that `layflat learn` wrote last"
    cycles = len(learnt.rested.angles)
    if len(asked) < cycles:
        what = f"lasts {len(asked)} control cycles, and the demand {cycles}"
        raise InputError(what, where=str(path), right=right)
    for sent, demand in ((learnt.sent, learnt.demand()), (learnt.best, learnt.best_demand())):
        measured = measured_during(demand, asked, angle, machine.cycle)
        if measured is not None:
            return replace(learnt, sent=sent), measured
    raise InputError("is not of a run of the demand to send next", where=str(path), right=right)


def _print_repeats(learnt: "Learnt", title: str) -> None:
    rows = [
        [str(k), f"{1e3 * one.rms:.2f}", f"{1e3 * one.most:.2f}", f"{one.landed:+.3f}", "yes" if one.kept else "no"]
        for k, one in enumerate(learnt.history)
    ]
    columns = ["repeat", "rms along the path (mm)", "at most (mm)", "within 2 mm, from the end (s)", "best so far"]
    print_table(columns, rows, f"{title}: distance of the tip from where it should be, by the sensors")
    best = min((one for one in learnt.history if one.kept), key=lambda one: one.rms)
    typer.echo(f"the best is {best.rms / learnt.history[0].rms:.2f} times the first run")


def _draw(learnt: "Learnt", angles: "list[Array]", path: Path) -> None:
    import numpy as np  # noqa: PLC0415

    from layflat.motion.kinematics import tip_position  # noqa: PLC0415
    from layflat.plot.style import save  # noqa: PLC0415
    from layflat.plot.tuning import Repeats, learning_figure  # noqa: PLC0415

    rested, cycle = learnt.rested.angles, learnt.wanted.cycle
    time = cycle * (np.arange(len(rested), dtype=np.float64) - learnt.lead_in)
    numbers = range(len(learnt.history) - len(angles), len(learnt.history))
    best = max((k for k in numbers if learnt.history[k].kept), default=numbers[-1])
    shown = {}
    for k, label in ((numbers[0], f"repeat {numbers[0]}"), (best, f"repeat {best}")):
        apart = tip_position(learnt.machine, angles[k - numbers[0]]) - tip_position(learnt.machine, rested)
        shown["first run" if k == 0 else label] = 1e3 * np.linalg.norm(apart, axis=1)
    added = 1e3 * learnt.corrections.states(learnt.best).angles.T
    history = learnt.history
    repeats = Repeats(
        [1e3 * one.rms for one in history], [1e3 * one.most for one in history], [o.kept for o in history]
    )
    duration = cycle * (len(learnt.wanted.angles) - 1)
    figure = learning_figure(time, duration, shown, dict(zip(learnt.machine.joints, added, strict=True)), repeats)
    typer.echo(f"wrote {save(figure, path)}")


def _write_demand(learnt: "Learnt", demand: Path, *, best: bool) -> None:
    import numpy as np  # noqa: PLC0415

    from layflat.motion.demand_file import write_demand  # noqa: PLC0415

    q, v, a = learnt.best_demand() if best else learnt.demand()
    time = learnt.wanted.cycle * np.arange(len(q), dtype=np.float64)
    typer.echo(f"wrote {write_demand(learnt.machine, time, q, demand, velocity=v, acceleration=a)}")
    typer.echo(f"the motion begins {learnt.how.lead_in:g} s after the demand")
