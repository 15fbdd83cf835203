"""Description of a machine: joints in an arm, with valve, supply, sensors and controller."""

import json
from functools import lru_cache
from hashlib import sha256
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Field, ModelWrapValidatorHandler, ValidationError, model_validator

from layflat.control import CONTROL_LAWS, ControlKind, ControllerPart
from layflat.description import DescribedFile, Part
from layflat.description import units as u
from layflat.description.change import forget_annotations
from layflat.description.explain import explain_error
from layflat.description.names import Key
from layflat.description.renamed import with_present_keys
from layflat.description.tables import Plain, Sources
from layflat.errors import MachineError
from layflat.jit.outside import load_kinds
from layflat.kinds import AnyKindOf, KindTable
from layflat.machine.gains import gains_of_law
from layflat.machine.interface import Interface, Safety
from layflat.machine.parts import Joint
from layflat.machine.tube import TubePart, delay
from layflat.physics.arms import ARM_KINDS, ArmPart
from layflat.physics.driver import MAX_DELAY_CYCLES
from layflat.physics.hysteresis import ParallelPart
from layflat.physics.valves import VALVE_KINDS, ValvePart
from layflat.plot.drawing import draw
from layflat.plot.tables import html_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DEFAULT_CYCLE = 0.005  # control cycle of a machine without a controller, s: the paper's


class AirSupply(Part):
    """Air supply and surroundings."""

    pressure_gauge: u.SupplyPressure
    temperature: u.Temperature
    ambient_pressure: u.AmbientPressure = Field(description="absolute")
    ambient_temperature: u.Temperature

    @property
    def pressure(self) -> float:
        """Absolute supply pressure, Pa."""
        return self.pressure_gauge + self.ambient_pressure


class AngleSensor(Part):
    """Angle sensor: potentiometer and converter, its range centred on the joint's mid-stroke."""

    range: u.PositiveAngle
    bits: Annotated[int, Field(ge=4, le=24)]
    noise: Annotated[float, u.ANGLE, Field(ge=0)]
    offset: u.Angle


class PressureSensor(Part):
    """Sensor of the differential pressure: transducer and converter, its range centred on zero."""

    range: u.PositivePressure
    bits: Annotated[int, Field(ge=4, le=24)]
    noise: u.PressureOrZero
    offset: u.AnyPressure


class Machine(DescribedFile):
    """Validated description of a machine; `provenance` has the source of each value by its dotted path.

    Example:
        >>> import layflat as lf
        >>> arm = lf.load("paper-arm")
        >>> isinstance(arm, lf.Machine), arm.joints["large"].hose.width
        (True, 0.16)
        >>> arm.provenance["joint.large.hose.width"].note
        'section 2.3'
        >>> figure = arm.plot()
    """

    kinds: tuple[str, ...] = Field(default=(), description="Python files that hold kinds which this machine uses")
    supply: AirSupply
    joint: dict[Key, Joint]
    arm: Annotated[ArmPart, AnyKindOf(ARM_KINDS)]
    valve: Annotated[ValvePart, AnyKindOf(VALVE_KINDS)] | None = None
    line: TubePart | None = Field(default=None, description="tube from the valve to each hose, for joints without one")
    angle_sensor: AngleSensor | None = None
    pressure_sensor: PressureSensor | None = None
    controller: Annotated[ControllerPart, AnyKindOf(CONTROL_LAWS)] | None = None
    interface: Interface = Field(default_factory=Interface)
    safety: Safety = Field(default_factory=Safety)

    @model_validator(mode="wrap")
    @classmethod
    def _validate_with_gains_of_law(cls, described: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Validate the machine with the table of gains that its control law defines."""
        controller = described.get("controller") if isinstance(described, dict) else None
        kind = controller.get("kind") if isinstance(controller, dict) else getattr(controller, "kind", None)
        with gains_of_law(kind):
            return handler(described)

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        """Raise ValueError unless arm, joints, valve and lines fit each other."""
        missing = [name for name in self.arm.joints if name not in self.joint]
        if missing:
            raise ValueError(f"arm.joints names the unknown joint {missing[0]!r}; joints are {sorted(self.joint)}")
        bare = [name for name in self.arm.joints if self.joint[name].link is None and not self.arm.own_links]
        if bare:
            name, kind = bare[0], self.arm.kind
            raise ValueError(f"joint {name!r} has no link, which a {kind} arm needs; add [joint.{name}.link]")
        if self.valve is not None and self.controller is not None:
            max_delay = MAX_DELAY_CYCLES * self.cycle
            if self.valve.delay > max_delay:
                limit = f"give up to {1000 * max_delay:g} ms"
                raise ValueError(f"valve.delay is longer than three control cycles; {limit}")
            for name, line in self.lines.items():
                if line is not None and self.valve.delay + delay(line) > max_delay:
                    raise ValueError(
                        f"delays of valve and line of joint {name!r} are together longer than three control cycles, "
                        f"{1000 * max_delay:g} ms; shorten the line, or give its delay"
                    )
        lines = set(map(type, self.lines.values()))
        if len(lines) > 1:
            lacking = next(name for name, line in self.lines.items() if line is None)
            raise ValueError(f"joint {lacking!r} has no line, but others have; give all joints one, or none")
        return self

    def __reduce__(self) -> Any:
        """Pickle a machine such that users' kinds are loaded in the other process."""
        if not self.kinds:
            return super().__reduce__()
        return restore, (self.model_dump_json(), self.origin)

    def __eq__(self, other: object) -> bool:
        """Return whether all values are equal, whatever their sources."""
        return isinstance(other, Machine) and self.__dict__ == other.__dict__

    __hash__ = None  # type: ignore[assignment]  # joints are a table

    @property
    def control_law(self) -> ControlKind:
        """Kind of control law; the paper's for a machine without a controller."""
        return CONTROL_LAWS.named(getattr(self.controller, "kind", CONTROL_LAWS.usual))

    @property
    def cycle(self) -> float:
        """Control cycle, s; without a controller, the time between changes of the valves' voltages."""
        return self.controller.cycle if self.controller is not None else DEFAULT_CYCLE

    @property
    def fingerprint(self) -> str:
        """SHA-256 of the complete description."""
        return sha256(self.model_dump_json().encode()).hexdigest()

    @property
    def lines(self) -> dict[str, TubePart | None]:
        """Tubes from the valve to each hose, by joint; None where the valve is directly on the hose."""
        return {name: self.line if joint.line is None else joint.line for name, joint in self.joints.items()}

    @property
    def joints(self) -> dict[str, Joint]:
        """Joints that the arm uses, by name, from base to tip."""
        return {name: self.joint[name] for name in self.arm.joints}

    def plot(self) -> "Figure":
        """Draw the arm, in mid-stroke and at the ends of its strokes, and where its tip goes."""
        return draw(self)

    def _repr_html_(self) -> str:
        """Return a table of supply, payload, control law and joints, for notebooks."""
        rows = [("supply", f"{self.supply.pressure_gauge / 1e5:g} bar gauge"), ("payload", f"{self.arm.payload:g} kg")]
        if self.controller is not None:
            rows.append(("control law", f"{self.controller.kind}, every {1e3 * self.cycle:g} ms"))
        for name, joint in self.joints.items():
            hose = f"hose of {1e3 * joint.hose.width:g} mm on a cylinder of {1e3 * joint.cylinder.diameter:g} mm"
            rows.append((f"{name} joint", f"{hose}, working stroke {degrees(joint.stops.working_stroke):g} deg"))
        return html_table(f"{self.name}: {self.title}", (), rows)


def build(plain: Plain, sources: Sources, where: str) -> Machine:
    """Return the validated machine of plain tables; the files of kinds that they name are run first.

    Args:
        plain: nested tables of values as written.
        sources: sources of the values, by dotted path.
        where: the file or name, for messages.

    Raises:
        MachineError: a key or value is wrong; the message names it.
        KindError: a file of kinds can't be run.
    """
    files = plain.get("kinds")
    if isinstance(files, (list, tuple)) and all(isinstance(path, str) for path in files):  # others are refused below
        for path in files:
            load_kinds(Path(path), f"{where}: kinds")
    _know_all_kinds(KindTable.registered)
    try:
        machine = Machine.model_validate(plain)
    except ValidationError as error:
        raise explain_error(
            error, where, Machine, MachineError, "`layflat machine show paper-arm` shows a complete description"
        ) from None
    machine._provenance.update(sources)
    machine._origin = where
    return machine


def restore(text: str, where: str = "machine") -> Machine:
    """Return a machine from its JSON text in a run or log of any version.

    Args:
        text: the text.
        where: origin of the machine, for messages.

    Raises:
        MachineError: the text is not JSON of a table, or a key or value in it is wrong.
    """
    right = "give the JSON text of a machine, as a run holds it"
    try:
        plain = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise MachineError(f"is not JSON ({error})", where=where, right=right) from None
    if not isinstance(plain, dict):
        raise MachineError("is no table", where=where, right=right)
    return build(with_present_keys("machine", plain)[0], {}, where)


@lru_cache(maxsize=1)
def _know_all_kinds(registered: int) -> None:  # noqa: ARG001  # evaluated again whenever the number of kinds changes
    """Rebuild the models whose fields depend on the registered kinds; `registered` is their number."""
    for part in (ParallelPart, Joint, Machine):
        if part.__pydantic_complete__:
            part.model_rebuild(force=True)
    forget_annotations()
