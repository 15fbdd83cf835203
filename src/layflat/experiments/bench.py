"""The machines of the paper's experiments, all derived from one arm, and what an experimenter may change in them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import degrees

from layflat.errors import MachineError
from layflat.machine import Machine, changed, load, parameters
from layflat.machine.model import SpoolValve

RIGS = (
    "rig-polyester",
    "rig-single-thickness",
    "rig-polyester-plate",
    "rig-polyester-polythene",
    "rig-kevlar",
    "rig-kevlar-plate",
    "rig-shell-steel",
)
"""The single-acting rigs of Figs 2 to 5."""

INERTIA_PER_TORQUE = 1e-2
"""kg m2 per N m: the ratio at which the paper compares joints (sections 4.1 and 5)."""


def alone(arm: Machine, joint: str, payload: float) -> Machine:
    """One joint of an arm on a fixed base, with a payload (kg) at the end of its link."""
    return changed(changed(arm, "arm.joints", (joint,)), "arm.payload", payload)


@dataclass(frozen=True)
class Bench:
    """The arm under test and the paper's other machines.

    Args:
        arm: two joints named "large" and "small".
        earlier: the earlier actuator, with a joint named "small".
        brake: share of the brakes' torque in every experiment with brakes.
    """

    arm: Machine
    earlier: Machine
    brake: float = 1.0

    @property
    def valve(self) -> SpoolValve:
        """The arm's valve."""
        assert isinstance(self.arm.valve, SpoolValve)
        return self.arm.valve

    @cached_property
    def axis_one(self) -> Machine:
        """The small joint alone with the paper's 2 kg at 0.4 m, and the controller of the earlier actuator."""
        return changed(alone(self.arm, "small", 2.0), "joint.small.gains", self.earlier.joint["small"].gains)

    @cached_property
    def earlier_scaled(self) -> Machine:
        """The earlier actuator with the pressure gains of its controller scaled to its torque."""
        gains = self.earlier.joint["small"].gains
        if gains is None:
            return self.earlier
        scale = maximum_torque(self.earlier, "small") / maximum_torque(self.arm, "small")
        for phase in ("far", "near", "close"):
            own = getattr(gains, phase)
            own = own.model_copy(update={"pressure": own.pressure * scale})
            gains = gains.model_copy(update={phase: own})
        return changed(self.earlier, "joint.small.gains", gains)

    @cached_property
    def rigs(self) -> dict[str, Machine]:
        """The single-acting rigs by name."""
        return {name: load(name) for name in RIGS}


def bench(arm: str | Machine = "paper-arm") -> Bench:
    """The bench of an arm: a built-in name, a file or a machine.

    Raises:
        MachineError: it is no arm of a joint "large" and a joint "small", as the paper's experiments need it.
    """
    loaded = load(arm)
    if loaded.arm.joints != ("large", "small"):
        raise MachineError(
            f"{list(loaded.arm.joints)}",
            where=f"{loaded.origin}: arm.joints",
            right='the experiments need "large", "small"',
        )
    if not isinstance(loaded.valve, SpoolValve):
        raise MachineError(
            "is no spool valve", where=f"{loaded.origin}: valve", right='the experiments need one of kind "spool"'
        )
    return Bench(loaded, load("earlier-actuator"))


def maximum_torque(machine: Machine, joint: str) -> float:
    """Greatest torque at supply pressure without losses, N m."""
    return parameters.torque_constant(machine.joint[joint]) * machine.supply.pressure_gauge


def payload_for_inertia(machine: Machine, joint: str, inertia: float) -> float:
    """Payload (kg) at the link's end that makes an inertia (kg m2)."""
    return inertia / machine.joint[joint].link.length ** 2


def deg(angle: float) -> float:
    """An angle in degrees, rounded as it is reported."""
    return round(degrees(angle), 4)
