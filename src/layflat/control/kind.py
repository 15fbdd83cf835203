"""Kind of control law: inputs of the law in a control cycle, and the commands that it returns."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from pydantic import BaseModel

from layflat.control import checks
from layflat.control.checks import CycleClock, PlainStep, PlainWake, guard_step
from layflat.control.contract import Command
from layflat.description import units as u
from layflat.errors import KindError
from layflat.jit import Law, law
from layflat.kind_checks import MisfitError
from layflat.kinds import REQUIRED, Kind, KindPart
from layflat.lanes import each
from layflat.physics.adjustable import FULL, Shares


class ControllerPart(KindPart):
    """Description of a controller: fields that all kinds share."""

    cycle: u.ControlCycle


@law
def _whole(voltage: float) -> Shares:  # noqa: ARG001  (one a joint)
    return FULL


@law
def voltages_alone(voltage: Any) -> Any:
    """Command voltages, and leave all else as it is."""
    return Command(voltage, each(_whole, voltage))


@law
def no_shift(settings: Any, memory: Any, joints: Any) -> Any:  # noqa: ARG001
    """No shift of any valve's centre; `joints` is a tuple of zeros with an item per joint."""
    return joints


@dataclass(frozen=True, kw_only=True)
class ControlKind(Kind):
    """A control law of the whole arm.

    `parameters(described, machine)` yields the law's settings from the described controller and the machine that it is
    for (see also `models_plant`): a named tuple of floats, of named tuples and of tuples of these, with an item a
    joint. Laws are pure: no clock, no input or output, no plant. Those that are decorated with `layflat.jit.law` are
    compiled, and run in ensembles, in studies and on rigs; plain functions run in rollouts and on a virtual rig.
    """

    CALLED = ("wake", "step", "centre_shift")

    wake: Callable[..., Any] = REQUIRED
    """`wake(settings, sensed)` yields the memory of a law that begins at these measurements, nested as settings."""
    step: Callable[..., Any] = REQUIRED
    """`step(settings, memory, sensed, demand, elapsed)` yields memory, `Command` and report after a cycle that came
    `elapsed` s after the one before. A report is a tuple of `report`, one a joint."""
    report: type = REQUIRED
    """Named tuple class of what the law shows of each joint, all floats; its fields are recorded by name."""
    signals: Mapping[str, tuple[str, str]] = REQUIRED  # unit and meaning of each field of `report`
    gains: type[BaseModel] | None = None  # description of the table `gains` of each joint; None where the law has none
    centre_shift: Callable[..., Any] = no_shift
    """`centre_shift(settings, memory, joints)` yields by how much each valve's centre is estimated to be off, V, a
    tuple with an item per joint, as the zeros `joints` are. A rig's supervision of air takes it into account; zero
    unless it is given."""
    plans: bool = False
    """Whether the law plans its own motion to a demand: one that jumps it may be given whole, one that moves with its
    velocity and acceleration, and the arm is then as fast as hoses and valves allow. A law that goes by errors is led
    by the rig: its demands jump only so far, go on with `safety.demand_speed`, and have no rates."""
    models_plant: bool = False
    """Whether `parameters` takes a third argument: a function without arguments that returns the parameters of the
    plant's laws (those of its arm, of its joints, and of what is around them)."""
    gives_up: str | None = None
    """Field of `report` that is 1 while the law holds the arm instead of following, since what it believes of the arm
    is too far from it; runs and rigs tell so. None: it never does."""

    def __post_init__(self) -> None:
        """Refuse a report whose signals have no unit; let laws in plain Python be checked in every cycle."""
        super().__post_init__()
        try:
            checks.check_report(self.report, self.signals)
        except MisfitError as error:
            raise KindError(str(error), where=f"control law {self.name!r}") from None
        unexplained = [name for name in getattr(self.report, "_fields", ()) if name not in self.signals]
        if unexplained:
            raise KindError(f"signal {unexplained[0]!r} has no unit and meaning", where=f"control law {self.name!r}")
        if self.gives_up is not None and self.gives_up not in self.signals:
            raise KindError(f"gives up by {self.gives_up!r}, which is no signal", where=f"control law {self.name!r}")
        clock = CycleClock()
        if not isinstance(self.wake, Law | PlainWake):
            object.__setattr__(self, "wake", PlainWake(self.name, self.wake, clock))
        if not isinstance(self.step, Law | PlainStep):
            object.__setattr__(self, "step", PlainStep(self.name, self.step, self.report, clock))

    def guarded(self) -> "ControlKind":
        """Return the kind with voltages that are not numbers where its law returns what it may not.

        A law in plain Python is checked itself.
        """
        return replace(self, step=guard_step(self.step)) if self.compiled else self

    def try_laws(self, parameters: Any, *described: Any) -> None:
        """Try the law at rest: see `layflat.control.checks.try_law`."""
        controller, machine, *_ = described
        checks.try_law(self, parameters, len(machine.joints), controller.cycle)

    def check_compiled(self, where: str) -> None:
        """Make sure that the law can be compiled, as it has to be `where`; raise KindError if it is plain Python."""
        if not self.compiled:
            raise KindError(
                f"control law {self.name!r} is plain Python; it can't run {where}",
                right="decorate its functions with layflat.jit.law",
            )

    @property
    def compiled(self) -> bool:
        """True where the law can be compiled; else Python calls it once a control cycle."""
        return isinstance(self.wake, Law) and isinstance(self.step, Law)
