"""Kind of control law: inputs of the law in a control cycle, and the commands that it returns."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from pydantic import BaseModel

from layflat.control import checks
from layflat.control.checks import CycleClock, PlainStep, PlainWake, guard_step
from layflat.control.signals import Command
from layflat.description import units as u
from layflat.errors import KindError
from layflat.jit import Law, law
from layflat.kind_checks import MisfitError
from layflat.kinds import REQUIRED_ENTRY, Kind, KindPart
from layflat.lanes import each
from layflat.physics.adjustable import FULL_FRACTIONS, DriveFractions


class ControllerPart(KindPart):
    """Description of a controller: the fields that all kinds share."""

    cycle: u.ControlCycle


@law
def _full_shares(voltage: float) -> DriveFractions:  # noqa: ARG001  (one a joint)
    return FULL_FRACTIONS


@law
def voltages_alone(voltage: Any) -> Any:
    """Return a command of voltages (V, a tuple) with full shares of brake, dither and supply."""
    return Command(voltage, each(_full_shares, voltage))


@law
def no_shift(settings: Any, memory: Any, joints: Any) -> Any:  # noqa: ARG001
    """Return zero shift of every valve's centre; `joints` is a tuple of zeros with an item per joint."""
    return joints


@dataclass(frozen=True, kw_only=True)
class ControlKind(Kind):
    """A control law of the whole arm.

    `parameters(described, machine)` returns the law's settings for a described controller and its machine (see also
    `models_plant`): a named tuple of floats, of named tuples and of tuples of these, with an item per joint. Laws are
    pure: no clock, no input or output, no plant. Functions decorated with `layflat.jit.law` are compiled, and run in
    ensembles, in studies and on rigs; plain functions run in rollouts and on a virtual rig.
    """

    CALLED = ("wake", "step", "centre_shift")

    wake: Callable[..., Any] = REQUIRED_ENTRY
    """`wake(settings, sensed)` returns the memory of a law that starts at these readings, nested as settings are."""
    step: Callable[..., Any] = REQUIRED_ENTRY
    """`step(settings, memory, sensed, demand, elapsed)` returns memory, `Command` and report after a cycle `elapsed` s
    after the one before. The report is a tuple of `report`, one per joint."""
    report: type = REQUIRED_ENTRY
    """Named tuple class of a joint's report, all floats; its fields are recorded by name."""
    signals: Mapping[str, tuple[str, str]] = REQUIRED_ENTRY  # unit and meaning of each field of `report`
    gains: type[BaseModel] | None = None  # description of the table `gains` of each joint; None for a law without gains
    centre_shift: Callable[..., Any] = no_shift
    """`centre_shift(settings, memory, joints)` returns the estimated error of each valve's centre, V, a tuple with an
    item per joint, as `joints`, which are zeros. A rig's supervision of air takes it into account. Default: zero."""
    plans: bool = False
    """True if the law plans its own motion to a demand. Then the demand may jump, or move with velocity and
    acceleration, and the arm is as fast as hoses and valves allow. For other laws, which control errors, the rig ramps
    the demand: its jumps are limited, it moves with `safety.demand_speed`, and it has no rates."""
    models_plant: bool = False
    """True if `parameters` takes a third argument: a function without arguments that returns the parameters of the
    plant's laws (of its arm, of its joints, and of its surroundings)."""
    gives_up: str | None = None
    """Field of `report` that is 1 while the law holds the arm in place of following, since its model is too far from
    the arm; runs and rigs report it. None for a law that never does."""

    def __post_init__(self) -> None:
        """Wrap `wake` and `step` in plain Python so that every cycle is checked.

        Raise KindError if the kind is incomplete, or if `report`, `signals` and `gives_up` disagree.
        """
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
        """Return the kind with a `step` whose voltages are NaN if it returns an invalid value (see `guard_step`).

        A law in plain Python stays as it is: it raises KindError for such values.
        """
        return replace(self, step=guard_step(self.step)) if self.compiled else self

    def try_laws(self, parameters: Any, *described: Any) -> None:
        """Test the law at rest: see `layflat.control.checks.try_law`."""
        controller, machine, *_ = described
        checks.try_law(self, parameters, len(machine.joints), controller.cycle)

    def check_compiled(self, where: str) -> None:
        """Check that the law can be compiled, as `where` requires; raise KindError if it is plain Python."""
        if not self.compiled:
            raise KindError(
                f"control law {self.name!r} is plain Python; it can't run {where}",
                right="decorate its functions with layflat.jit.law",
            )

    @property
    def compiled(self) -> bool:
        """True if the law can be compiled; otherwise Python calls it once per control cycle."""
        return isinstance(self.wake, Law) and isinstance(self.step, Law)
