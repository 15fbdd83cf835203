"""Machines of the paper's experiments, all derived from one arm."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from layflat.description.change import changed_all
from layflat.errors import MachineError
from layflat.machine import Machine, changed, load, parameters
from layflat.machine.cloud import split_member_name
from layflat.machine.gains import check_papers_law
from layflat.machine.parts import Joint
from layflat.physics.valves.spool import SpoolValvePart
from layflat.sim.sweep import HysteresisLoop, sweep

RIG_NAMES = (
    "rig-polyester",
    "rig-single-thickness",
    "rig-polyester-plate",
    "rig-polyester-polythene",
    "rig-kevlar",
    "rig-kevlar-plate",
    "rig-shell-steel",
)
"""The single-acting rigs of Figs 2 to 5."""

INERTIA_PER_TORQUE = 1e-2  # kg m2 per N m: the ratio at which the paper compares joints (sections 4.1 and 5)


def isolate_joint(arm: Machine, joint: str, payload: float) -> Machine:
    """Return one joint of an arm on a fixed base, with a payload at the end of its link.

    Args:
        arm: machine that has the joint.
        joint: its name.
        payload: kg.
    """
    return changed(changed(arm, "arm.joints", (joint,)), "arm.payload", payload)


@dataclass(frozen=True)
class ReproductionBench:
    """The machine under test and the paper's other machines."""

    arm: Machine  # under test; experiments use its joints "large" and "small"
    earlier: Machine  # the earlier actuator, with a joint named "small"
    brake: float = 1.0  # fraction of the brakes' torque in every experiment with brakes

    def joint(self, name: str) -> Joint:
        """Return a joint of the machine under test (MachineError: it has none of this name)."""
        if name not in self.arm.joints:
            raise MachineError(f"has no joint {name!r}", where=self.arm.origin, right="test an arm that has one")
        return self.arm.joints[name]

    @property
    def valve(self) -> SpoolValvePart:
        """The spool valve of the machine under test (MachineError: it has none)."""
        if not isinstance(self.arm.valve, SpoolValvePart):
            raise MachineError("has no spool valve", where=self.arm.origin, right='add a valve of kind "spool"')
        return self.arm.valve

    def curve(
        self, name: str, machine: Machine | None = None, *, brake: float = 1.0, share: float | None = None
    ) -> HysteresisLoop:
        """Sweep a joint at the supply pressure of the machine under test, and return its hysteresis curve.

        Args:
            name: name of the joint.
            machine: default: the machine under test.
            brake: torque of the brake, as a fraction of its full torque.
            share: share of the small joint's stroke that is swept; default: the joint's own working stroke.

        Raises:
            MachineError: the machine under test has no such joint.
        """
        self.joint(name)
        stroke = share and share * self.joint("small").stops.working_stroke
        return sweep(machine or self.arm, name, self.arm.supply.pressure_gauge, brake=brake, stroke=stroke)

    @cached_property
    def axis_one(self) -> Machine:
        """The small joint alone with the paper's 2 kg, and the gains of the earlier actuator."""
        self.joint("small")
        return changed(isolate_joint(self.arm, "small", 2.0), "joint.small.gains", self.earlier.joint["small"].gains)

    @cached_property
    def earlier_scaled(self) -> Machine:
        """The earlier actuator, its pressure gains, if any, scaled by its torque over that of the small joint."""
        gains = self.earlier.joint["small"].gains
        if gains is None:
            return self.earlier
        scale = maximum_torque(self.earlier, "small") / maximum_torque(self.arm, "small")
        scaled = {
            f"joint.small.gains.{phase}.pressure": getattr(gains, phase).pressure * scale
            for phase in ("far", "near", "close")
        }
        return changed_all(self.earlier, scaled)

    @cached_property
    def rigs(self) -> dict[str, Machine]:
        """The single-acting rigs by name."""
        return {name: load(name) for name in RIG_NAMES}


def load_bench(arm: str | Path | Machine = "paper-arm") -> ReproductionBench:
    """Return the bench of a machine under test: a built-in name, a file or a machine.

    The earlier actuator of a cloud's member is that of the same member.

    Raises:
        MachineError: the machine is wrong, or its controller is not the paper's.
    """
    member = None if isinstance(arm, Machine) else split_member_name(str(arm))
    machine = load(arm)
    check_papers_law(machine, "the reproduction of the paper")
    return ReproductionBench(
        machine, load(f"earlier-actuator@{member[1]}:{member[2]}" if member else "earlier-actuator")
    )


def maximum_torque(machine: Machine, joint: str) -> float:
    """Return a joint's greatest torque at the machine's supply pressure, without losses, N m."""
    return parameters.torque_constant(machine.joint[joint]) * machine.supply.pressure_gauge


def payload_for_inertia(machine: Machine, joint: str, inertia: float) -> float:
    """Return the payload at the end of a joint's link that has an inertia about the joint, kg.

    Args:
        machine: machine that has the joint.
        joint: its name.
        inertia: kg m2.
    """
    return inertia / machine.joint[joint].planar_link.length ** 2
