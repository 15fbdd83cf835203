"""Control cycle of a rig as entries: air balance, detectors, demands, estimator, control law and voltages.

It is the compiled cycle of the rig's loop itself (`rig/safety/cycle.py`), on the caller's memory.
"""

from collections.abc import Iterator
from math import isfinite
from typing import Any, NamedTuple

from layflat.control import CONTROL_LAWS
from layflat.export.entries import Argument, Entry, number_of
from layflat.export.header import Table
from layflat.lanes import Like, read_numbers, write_numbers
from layflat.machine import Machine, parameters
from layflat.physics.air_balance import AirEstimate
from layflat.physics.joint import REST_PRESSURE_RATIO
from layflat.rig.law import ArmLaw
from layflat.rig.named import NamedRows
from layflat.rig.safety.core import CycleCore
from layflat.rig.safety.cycle import CycleLikes, run_cycle
from layflat.rig.safety.cycle_numbers import (
    INPUT_OFFSETS,
    JOINT_INPUT_COUNT,
    JOINT_INPUT_OFFSETS,
    JOINT_TEMPLATE,
    MEMORY_OFFSETS,
    MEMORY_TEMPLATE,
    RIG_TEMPLATE,
    SETTINGS_TEMPLATE,
)


class ByJoint(NamedTuple):
    """Values of all joints, base to tip."""

    joints: tuple[Any, ...]


class Workspace(NamedTuple):
    """Workspace of a cycle, whose content does not matter between calls."""

    numbers: tuple[float, ...]


class CycleEntries:
    """Control cycle of a machine's rig as entries.

    Args:
        machine: the machine.
        late: control cycles after which the valves get the voltages, besides the valve's own delay.

    Raises:
        MachineError: the machine has no valve, sensors, controller or gains.
        KindError: the law is plain Python, or commands a fraction of brake, dither or supply.
    """

    def __init__(self, machine: Machine, late: int = 0) -> None:
        self.law = ArmLaw(machine, late)
        CONTROL_LAWS.kind_of(self.law.settings_as_given).check_compiled("in C")
        self.core, self.arm = CycleCore(machine, self.law), parameters.arm(machine)
        self.joints, kind = len(machine.joints), self.law.kind
        self.rejection_column = list(kind.signals).index(kind.gives_up) if kind.gives_up is not None else -1
        self.samples, self.report = (
            ByJoint((JOINT_TEMPLATE,) * self.joints),
            ByJoint((self.law.report.like,) * self.joints),
        )
        self.law_settings, self.law_memory = self.law.settings.like, self.law.memory.like
        self.workspace = Workspace((0.0,) * ((2 * self.joints + 4) * (self.joints + 1)))

        core = self.core
        self.rig, self.inputs = _rows(core.rig)[0], _rows(core.inputs)[0]
        self.settings, self.memory = ByJoint(_rows(core.settings)), ByJoint(_rows(core.memory))

    def tables(self) -> Iterator[Table]:
        """Yield the settings, and the content of the memory before a start."""
        yield Table("rig_settings", self.rig, "Settings of the machine as a whole.")
        yield Table("cycle_settings", self.settings, "Settings of the joints.")
        yield Table("cycle_inputs", self.inputs, "Inputs and memory of the machine as a whole, before a start.")
        yield Table("cycle_memory", self.memory, "Memory of the joints, before a start.")
        yield Table("arm_settings", self.arm, "Parameters of the arm.")
        yield Table("law_settings", self.law_settings, "Settings of the control law.")

    def __iter__(self) -> Iterator[Entry]:
        """Yield the entries."""
        memory = Argument("memory", "memory of the joints", self.memory, output=True, struct="cycle_memory")
        rig, samples = "settings of the machine as a whole", "samples and demands of the joints"
        yield Entry(
            "cycle_start",
            "Initialise the memory by the first samples: the air in the hoses, and demands at the present angles.",
            (
                Argument("rig", rig, self.rig, struct="rig_settings"),
                Argument(
                    "inputs", "inputs of the cycle, of which the supply counts", self.inputs, struct="cycle_inputs"
                ),
                Argument("samples", "samples of the joints", self.samples, struct="cycle_samples"),
                memory,
                Argument("filled", "1 if the hoses hold the pressure of centred valves, else 0", number="int32_t"),
            ),
            self._start(),
            lanes=False,
        )
        yield Entry(
            "cycle_run",
            "Run stages of a control cycle.",
            (
                Argument("rig", rig, self.rig, struct="rig_settings"),
                Argument("settings", "settings of the joints", self.settings, struct="cycle_settings"),
                Argument(
                    "inputs", "inputs, and memory of the machine as a whole", self.inputs, output=True,
                    struct="cycle_inputs",
                ),
                Argument("samples", samples, self.samples, output=True, struct="cycle_samples"),
                memory,
                Argument("arm", "parameters of the arm", self.arm, struct="arm_settings"),
                Argument("law", "settings of the control law", self.law_settings, struct="law_settings"),
                Argument("law_memory", "memory of the control law", self.law_memory, output=True),
                Argument("report", "report of the control law", self.report, output=True, struct="law_report"),
                Argument("workspace", "workspace", self.workspace, output=True, struct="cycle_workspace"),
                Argument("stages", "flags of the stages that are run", number="int32_t"),
            ),
            self._run(),
            "flags of the outcome",
            lanes=False,
        )  # fmt: skip

    def _start(self) -> Any:
        from numba import carray  # type: ignore[attr-defined]  # noqa: PLC0415  # only where something is exported

        n = self.joints
        rig_size, inputs_size, memory_size = map(number_of, (RIG_TEMPLATE, self.inputs, MEMORY_TEMPLATE))
        air_at, demand_at, velocity_at = MEMORY_OFFSETS.air, MEMORY_OFFSETS.demand, MEMORY_OFFSETS.velocity
        supply_at, angle_at, pressure_at = INPUT_OFFSETS.supply, JOINT_INPUT_OFFSETS.angle, JOINT_INPUT_OFFSETS.pressure

        def start(rig, inputs, joint_inputs, memory, filled):  # type: ignore[no-untyped-def]
            ambient = read_numbers(RIG_TEMPLATE, carray(rig, (rig_size,))).ambient
            supply, samples = carray(inputs, (inputs_size,))[supply_at], carray(joint_inputs, (n, JOINT_INPUT_COUNT))
            rows, held = carray(memory, (n, memory_size)), ambient
            if filled != 0:
                held = max(REST_PRESSURE_RATIO * supply, ambient)
            for j in range(n):
                angle, pressure = samples[j, angle_at], samples[j, pressure_at]
                half = 0.5 * pressure if isfinite(pressure) else 0.0
                write_numbers(rows[j, air_at:], AirEstimate(held + half, held - half, angle, 0.0, 0.0))
                if isfinite(angle):
                    rows[j, demand_at] = rows[j, demand_at + 1] = angle
                rows[j, velocity_at] = rows[j, velocity_at + 1] = 0.0

        return start

    def _run(self) -> Any:
        from numba import carray  # type: ignore[attr-defined]  # noqa: PLC0415  # only where something is exported

        n, nothing, column = self.joints, (0.0,) * self.joints, self.rejection_column
        arm_like, law_like, law_memory_like = map(Like.from_tuple, (self.arm, self.law_settings, self.law_memory))
        tuples = RIG_TEMPLATE, SETTINGS_TEMPLATE, self.inputs, MEMORY_TEMPLATE, self.law.report.like
        rig_size, settings_size, inputs_size, memory_size, report_size = map(number_of, tuples)
        arm_size, law_size, law_memory_size = map(number_of, (self.arm, self.law_settings, self.law_memory))

        def run(rig, settings, inputs, joint_inputs, memory, arm, law, law_memory, report, workspace, stages):  # type: ignore[no-untyped-def]
            return run_cycle(
                CycleLikes(arm_like, law_like, law_memory_like), nothing, column,
                carray(rig, (rig_size,)), carray(settings, (n, settings_size)), carray(inputs, (inputs_size,)),
                carray(joint_inputs, (n, JOINT_INPUT_COUNT)), carray(memory, (n, memory_size)),
                carray(arm, (arm_size,)), carray(law, (law_size,)), carray(law_memory, (law_memory_size,)),
                carray(report, (n, report_size)), carray(workspace, (2 * n + 4, n + 1)), stages,
            )  # fmt: skip

        return run


def _rows(rows: NamedRows) -> tuple[Any, ...]:
    """Return the rows as tuples."""
    return tuple(read_numbers(rows.like, row) for row in rows.array)
