"""The supervisor of a rig on a microcontroller computes this computer's numbers, while all kinds of things fail."""

from pathlib import Path

import numpy as np
import pytest

from layflat.errors import MachineError
from layflat.export.firmware.supervisor import SupervisorEntries
from layflat.export.header import Api
from layflat.lanes import leaves
from layflat.machine import load
from layflat.rig.law import ArmLaw
from layflat.rig.safety.core import CycleCore
from layflat.rig.safety.cycle_numbers import max_events
from layflat.rig.safety.faults import RigState
from tests.export.firmware.boards import BOARDS, WHOLE_CHECK, require_tools
from tests.export.firmware.supervisors import HostSupervisor, Trace, record_supervisor, replay_inputs

MAX_INSTRUCTIONS = {  # of a cycle
    ("paper-arm", "cortex-m7", "double"): 9_000,
    ("paper-arm", "cortex-m4f", "single"): 10_000,
    ("paper-arm", "cortex-m4f", "double"): 200_000,  # emulated
    ("paper-arm-tracking", "cortex-m7", "double"): 40_000,
    ("paper-arm-tracking", "cortex-m4f", "single"): 40_000,
}
FLASH, RAM = 128 * 1024, 16 * 1024  # of a small microcontroller, bytes
SHORT, LONG = 1200, 12_000  # cycles: 6 s and 60 s
CASES = [
    *(pytest.param(*case, SHORT) for case in MAX_INSTRUCTIONS if "tracking" not in case[0]),
    *(pytest.param(*case, LONG, marks=WHOLE_CHECK) for case in MAX_INSTRUCTIONS),
]

Traces = dict[tuple[str, str, int], Trace]
HostSupervisors = dict[tuple[str, str], HostSupervisor]


@pytest.fixture(scope="module")
def traces() -> Traces:
    """Traces by machine, precision and number of cycles, each recorded once."""
    return {}


@pytest.fixture(scope="module")
def supervisors() -> HostSupervisors:
    """Supervisors as object files of this computer, by machine and precision, each compiled once."""
    return {}


def supervisor_of(supervisors: HostSupervisors, name: str, precision: str) -> HostSupervisor:
    if (name, precision) not in supervisors:
        supervisors[name, precision] = HostSupervisor(load(name), precision)
    return supervisors[name, precision]


def trace_of(traces: Traces, supervisors: HostSupervisors, name: str, precision: str, cycles: int) -> Trace:
    """Trace of the loop itself, in single precision with the exported supervisor in it."""
    key = name, precision, cycles
    if key not in traces:
        other = supervisor_of(supervisors, name, precision) if precision == "single" else None
        traces[key] = record_supervisor(load(name), cycles, other=other)
    return traces[key]


@pytest.mark.parametrize(("name", "target", "precision", "cycles"), CASES)
def test_a_board_has_the_trace_of_the_loop(
    traces: Traces, supervisors: HostSupervisors, name: str, target: str, precision: str, cycles: int, tmp_path: Path
) -> None:
    require_tools()
    trace = trace_of(traces, supervisors, name, precision, cycles)
    supervisor = supervisor_of(supervisors, name, precision)
    done = replay_inputs(supervisor, trace.inputs, target, BOARDS[target], tmp_path)
    np.testing.assert_array_equal(done.after, trace.after.astype(supervisor.real))
    assert done.instructions.max() <= MAX_INSTRUCTIONS[name, target, precision]
    assert done.flash <= FLASH
    assert done.ram <= RAM


def test_a_loop_with_the_exported_supervisor_is_the_loop(traces: Traces, supervisors: HostSupervisors) -> None:
    trace = trace_of(traces, supervisors, "paper-arm", "double", SHORT)
    other = record_supervisor(load("paper-arm"), SHORT, other=supervisor_of(supervisors, "paper-arm", "double"))
    assert other.events == trace.events
    np.testing.assert_array_equal(other.after, trace.after)
    states = {line.split(" -> ")[1].upper() for lines in trace.events for line in lines if " -> " in line}
    assert states >= {state.name for state in RigState} - {"OFF"}, "all kinds of things happen"


def test_tables_are_the_numbers_of_the_loop() -> None:
    arm = load("paper-arm")
    entries, law = SupervisorEntries(arm), ArmLaw(arm)
    core, tables = CycleCore(arm, law), {table.name: list(leaves(table.like)) for table in entries.tables()}
    settings = np.concatenate([core.rig.array[0], core.settings.array.ravel()])
    np.testing.assert_array_equal(tables["supervisor_settings"][: len(settings)], settings)
    np.testing.assert_array_equal(tables["supervisor_settings"][-law.settings.array.size :], law.settings.array[0])
    memory = np.concatenate([core.machine.array[0], core.memory.array.ravel(), law.memory.array[0]])
    np.testing.assert_array_equal(tables["supervisor_memory"], memory)


def test_the_header_tells_units_and_numbers() -> None:
    entries = SupervisorEntries(load("paper-arm"))
    header = Api("rig", "single", entries, entries.comments).header("rig", entries.constants(), entries.tables())
    for line in (
        "void rig_supervisor_cycle(\n    const rig_supervisor_settings *settings,\n",
        "#define RIG_STATE_MOVING 3 /*",
        "#define RIG_FAULT_E_STOP 22 /* e-stop */",
        f"    rig_rig_event events[{max_events(2)}];",
    ):
        assert line in header
    assert "float elapsed;                                      /* since the last samples, s */" in header


def test_a_machine_without_sensors_is_refused() -> None:
    with pytest.raises(MachineError, match="no valve or sensors"):
        SupervisorEntries(load("rig-kevlar"))
