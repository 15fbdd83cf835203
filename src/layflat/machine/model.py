"""The whole machine: joints in an arm, with valve, supply, sensors and controller."""

import json
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, ModelWrapValidatorHandler, ValidationError, model_validator

from layflat.control import CONTROL_LAWS, ControlKind, ControllerPart
from layflat.description import Part
from layflat.description import units as u
from layflat.description.change import forget_annotations
from layflat.description.explain import explained
from layflat.description.names import Key
from layflat.description.part import Described
from layflat.description.provenance import Sources
from layflat.description.tables import Plain
from layflat.errors import MachineError
from layflat.jit.outside import load_kinds
from layflat.kinds import AnyOf, Table
from layflat.machine.gains import gains_of_law
from layflat.machine.interface import Interface, Safety
from layflat.machine.parts import Joint
from layflat.machine.tube import Line, delay
from layflat.physics.arms import ARMS, ArmPart
from layflat.physics.delay import LONGEST
from layflat.physics.hysteresis import ParallelPart
from layflat.physics.valves import VALVES, ValvePart

FORMER = {"surplus": "air_residual"}
"""Keys of `safety` that have another name now; files and logs of earlier versions have the first."""

CYCLE = 0.005  # cycle of a machine without a controller, s: the paper's


class Supply(Part):
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
    """Potentiometer and converter; its range is centred on the joint's mid-stroke."""

    range: u.PositiveAngle
    bits: Annotated[int, Field(ge=4, le=24)]
    noise: Annotated[float, u.ANGLE, Field(ge=0)]
    offset: u.Angle


class PressureSensor(Part):
    """Differential pressure transducer and converter, centred on zero."""

    range: u.PositivePressure
    bits: Annotated[int, Field(ge=4, le=24)]
    noise: u.PressureOrZero
    offset: u.AnyPressure


class Machine(Described):
    """A validated description. `provenance` gives the source of each value by its dotted path."""

    kinds: tuple[str, ...] = Field(default=(), description="Python files that hold kinds which this machine uses")
    supply: Supply
    joint: dict[Key, Joint]
    arm: Annotated[ArmPart, AnyOf(ARMS)]
    valve: Annotated[ValvePart, AnyOf(VALVES)] | None = None
    line: Line | None = Field(default=None, description="tube from the valve to each hose, of joints without their own")
    angle_sensor: AngleSensor | None = None
    pressure_sensor: PressureSensor | None = None
    controller: Annotated[ControllerPart, AnyOf(CONTROL_LAWS)] | None = None
    interface: Interface = Field(default_factory=Interface)
    safety: Safety = Field(default_factory=Safety)

    @model_validator(mode="wrap")
    @classmethod
    def _with_gains_of_its_law(cls, described: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        controller = described.get("controller") if isinstance(described, dict) else None
        kind = controller.get("kind") if isinstance(controller, dict) else getattr(controller, "kind", None)
        with gains_of_law(kind):
            return handler(described)

    @model_validator(mode="after")
    def _joined(self) -> Self:
        missing = [name for name in self.arm.joints if name not in self.joint]
        if missing:
            raise ValueError(f"arm.joints names the unknown joint {missing[0]!r}; joints are {sorted(self.joint)}")
        bare = [name for name in self.arm.joints if self.joint[name].link is None and not self.arm.own_links]
        if bare:
            name, kind = bare[0], self.arm.kind
            raise ValueError(f"joint {name!r} has no link, which a {kind} arm needs; add [joint.{name}.link]")
        if self.valve is not None and self.controller is not None:
            longest = LONGEST * self.cycle
            if self.valve.delay > longest:
                raise ValueError(f"valve.delay is longer than three control cycles, {1000 * longest:g} ms")
            for name, line in self.lines.items():
                if line is not None and self.valve.delay + delay(line) > longest:
                    raise ValueError(
                        f"delays of valve and line of joint {name!r} are together longer than three control cycles, "
                        f"{1000 * longest:g} ms; shorten the line, or give its delay"
                    )
        lines = set(map(type, self.lines.values()))
        if len(lines) > 1:
            lacking = next(name for name, line in self.lines.items() if line is None)
            raise ValueError(f"joint {lacking!r} has no line, but others have; give all joints one, or none")
        return self

    def __reduce__(self) -> Any:
        """Machines with kinds from outside find them again in another process."""
        if not self.kinds:
            return super().__reduce__()
        return restored, (self.model_dump_json(), self.origin)

    def __eq__(self, other: object) -> bool:
        """Machines are equal if their values are, wherever these come from."""
        return isinstance(other, Machine) and self.__dict__ == other.__dict__

    __hash__ = None  # type: ignore[assignment]  # joints are a table

    @property
    def control_law(self) -> ControlKind:
        """The kind of control law; the paper's for a machine without a controller."""
        return CONTROL_LAWS.named(getattr(self.controller, "kind", CONTROL_LAWS.usual))

    @property
    def cycle(self) -> float:
        """Control cycle, s; without a controller, the time between changes of the valves' voltages."""
        return self.controller.cycle if self.controller is not None else CYCLE

    @property
    def lines(self) -> dict[str, Line | None]:
        """The tube from the valve to each hose, by joint; None where the valve sits on the hose."""
        return {name: self.line if joint.line is None else joint.line for name, joint in self.joints.items()}

    @property
    def joints(self) -> dict[str, Joint]:
        """The joints that the arm uses, by name, from the base to the tip."""
        return {name: self.joint[name] for name in self.arm.joints}


def build(plain: Plain, sources: Sources, where: str) -> Machine:
    """Validate plain tables into a machine; the files of kinds that they name are run first.

    Raises:
        MachineError: naming `where`, the key and the value.
        KindError: a file of kinds can't be run.
    """
    for path in plain.get("kinds", ()):
        load_kinds(Path(path), f"{where}: kinds")
    _know_all_kinds(Table.registered)
    if isinstance(safety := plain.get("safety"), dict):
        plain = plain | {"safety": {FORMER.get(key, key): value for key, value in safety.items()}}
    try:
        machine = Machine.model_validate(plain)
    except ValidationError as error:
        raise explained(
            error, where, Machine, MachineError, "`layflat show paper-arm` shows a complete description"
        ) from None
    machine._provenance.update(sources)
    machine._origin = where
    return machine


def restored(text: str, where: str = "") -> Machine:
    """Return a machine from the JSON that it was kept as, in a run or a log; raise MachineError if it is none."""
    return build(json.loads(text), {}, where)


@lru_cache(maxsize=1)
def _know_all_kinds(registered: int) -> None:  # noqa: ARG001  # again whenever their number changes
    for part in (ParallelPart, Joint, Machine):
        if part.__pydantic_complete__:
            part.model_rebuild(force=True)
    forget_annotations()
