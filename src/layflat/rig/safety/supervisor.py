"""Supervisor: outside the controller, it decides in every cycle whether the rig moves, holds or vents its hoses.

A cycle is one call of compiled code (supervision.py); this is its form for Python, with texts for people.
"""

from collections.abc import Iterable, Iterator, Sequence
from struct import Struct
from typing import NamedTuple

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import Driver, RigCommand, SensorReading
from layflat.rig.law import ArmLaw
from layflat.rig.safety.core import CycleCore
from layflat.rig.safety.cycle_numbers import CycleInputs
from layflat.rig.safety.faults import MODE_NO, STATE_NO, Fault, Reaction, RigState, ValveMode
from layflat.rig.safety.ledger import RESET_REFUSED, START_BARRED, START_UNRECORDED, STATE_ENTERED
from layflat.rig.safety.soft_start import begin_reading
from layflat.rig.safety.state_machine import Decision, carry_out
from layflat.rig.safety.supervision import write_results

INPUTS_FORMAT = Struct(f"{len(CycleInputs._fields)}d")
STATE_BY_NUMBER, MODE_BY_NUMBER, FAULT_BY_NUMBER = list(RigState), list(ValveMode), list(Fault)
REFUSAL_TEXTS = {
    START_BARRED: "no start: a fault is latched; give a reset first",
    START_UNRECORDED: "no start: nothing is recorded",
    RESET_REFUSED: "no reset: the fault is still there",
}
"""Texts of events that are neither faults nor changes of state."""


def event_texts(events: Iterable[tuple[float, float]], state: RigState, names: Sequence[str]) -> Iterator[str]:
    """Yield the texts of events.

    Args:
        events: number of each event and its joint, -1 for the machine as a whole.
        state: state before the first of them.
        names: names of the joints.
    """
    for number, joint in events:
        if number < STATE_ENTERED:
            where = "" if joint < 0.0 else f"joint {names[int(joint)]!r}: "
            yield f"{where}{FAULT_BY_NUMBER[int(number)].title}"
        elif number in REFUSAL_TEXTS:
            yield REFUSAL_TEXTS[number]
        else:
            before, state = state, STATE_BY_NUMBER[int(number - STATE_ENTERED)]
            yield f"{before.name.lower()} -> {state.name.lower()}"


class HostRequest(NamedTuple):
    """Request of the host in a cycle."""

    demands: list[float]  # rad; NaN where there is none yet
    start: bool = False  # edge: start softly and obey demands
    stop: bool = False  # edge: hold, then vent the hoses
    reset: bool = False  # edge: clear latched faults
    age: float = 0.0  # time since the last message of the host, s
    velocities: Sequence[float] | None = None  # rad/s; None or NaN: derived from the demands, as the next
    accelerations: Sequence[float] | None = None  # rad/s2
    since: float = 0.0  # time since the target instant of the demands, s
    hold: bool = False  # edge: hold the joints where they are, with air; a start ends it
    switched: Sequence[tuple[int, bool]] = ()  # edges: digital outputs by number, and whether they are on from now on


class FaultLedger:
    """Ledger of the faults of a rig, present and latched: those that the numbers of its cycle tell."""

    def __init__(self, core: CycleCore) -> None:
        machine, joints = core.machine, core.memory
        self._now, self._latched, self._reaction = (machine[name] for name in ("worst_now", "latched", "reaction"))
        self._joints_now, self._joints = joints["worst_now"], joints["latched"]
        self.events: list[str] = []  # events to be recorded; the loop clears them

    @property
    def now(self) -> Fault:
        """Return the worst fault of this cycle."""
        return FAULT_BY_NUMBER[int(self._now[0])]

    @property
    def latched(self) -> Fault:
        """Return the worst latched fault."""
        return FAULT_BY_NUMBER[int(self._latched[0])]

    @property
    def reaction(self) -> Reaction:
        """Return the worst reaction to latched faults."""
        return Reaction(int(self._reaction[0]))

    @property
    def worst(self) -> Fault:
        """Return the worst fault that is latched or of this cycle."""
        return max(self.latched, self.now)

    @property
    def joints(self) -> list[Fault]:
        """Return the worst latched fault of each joint."""
        return [FAULT_BY_NUMBER[int(fault)] for fault in self._joints]

    def worst_of(self, joint: int) -> Fault:
        """Return the worst fault of a joint that is latched or of this cycle."""
        return FAULT_BY_NUMBER[int(max(self._joints[joint], self._joints_now[joint]))]


class Supervisor:
    """Supervisor of a machine with valve and sensors, and of its control law: states, faults and reactions."""

    def __init__(self, machine: Machine, law: ArmLaw) -> None:
        self.core = core = CycleCore(machine, law)
        self.ledger = FaultLedger(core)
        # Demands of the controllers (rad) and voltages to send (V), (joints,); the arrays stay the same.
        self.demands, self.voltages = core.demands, core.voltages
        self.missed = False  # whether a cycle was left out before this one
        self.recording = True  # whether the rows are recorded; else no start is allowed
        self.state, self.valve_mode = RigState.OFF, ValveMode.CENTRE
        self.is_pressurised = False  # whether the dump valve is to connect the supply
        self.is_reset_bit_set = False  # whether the reset bit of the command is set
        self.is_vented = True  # whether the air is off and the time for venting the hoses has passed
        self.fault = 0.0  # number of the worst fault that is latched or of this cycle
        self.lost = 0  # replies lost in succession
        self.outputs = 0  # digital outputs that are on, as bits
        self._names, self._inputs = list(machine.joints), core.inputs.array[0]
        self._results, self._events = core.results.array[0], core.events.array

    def start_filled(self, reading: SensorReading) -> None:
        """Start with a first reading and air in the hoses, as in a simulated run: demands are obeyed at once."""
        core = self.core
        core.load_reading(reading)
        core.inputs["supply"][0] = reading.supply
        begin_reading(core.rows, 1.0)
        carry_out(core.rows, Decision(STATE_NO.READY, MODE_NO.HOLD, 0.0, 0.0))
        core.wake(reading)
        write_results(core.rows)
        self._read_results()

    def cycle(self, reading: SensorReading | None, request: HostRequest, elapsed: float, since: float) -> None:
        """Perform one control cycle, which sets `demands`, `voltages`, `outputs`, and the state of air and reset bit.

        Args:
            reading: reading of the sensors; None where the reply was lost.
            request: request of the host.
            elapsed: time since the last samples, s.
            since: time since the last cycle, s.
        """
        core, switched, on = self.core, 0, 0
        for number, is_on in request.switched:
            switched, on = switched | 1 << number, on & ~(1 << number) | is_on << number
        core.load_demands(request.demands, request.velocities, request.accelerations)
        sampled = (False, 0.0, False, DeviceState.RUNNING)
        if reading is not None:
            core.load_reading(reading)
            sampled = (True, reading.supply, reading.stopped, reading.device)
        INPUTS_FORMAT.pack_into(
            self._inputs, 0, *sampled, elapsed, since, request.start, request.stop, request.hold, request.reset,
            request.age, request.since, switched, on, self.missed, not self.recording,
        )  # fmt: skip
        core.run()
        self._read_results()

    def send(self, driver: Driver) -> None:
        """Send the command of this cycle to the device."""
        command = RigCommand(self.voltages.copy(), self.is_pressurised, self.is_reset_bit_set, self.outputs)
        driver.write(command)

    def record(self, rows: Array) -> None:
        """Write the signals of each joint, as in `record.RowLayout`, into rows, (joints, numbers)."""
        self.core.record(rows)

    def _read_results(self) -> None:
        """Read the results of the compiled cycle, and add its events to the ledger."""
        air, reset, outputs, state, mode, vented, fault, lost, events = self._results.tolist()
        self.is_pressurised, self.is_reset_bit_set, self.is_vented = air > 0.0, reset > 0.0, vented > 0.0
        self.outputs, self.fault, self.lost = int(outputs), fault, int(lost)
        if events:
            self.ledger.events += event_texts(self._events[: int(events)].tolist(), self.state, self._names)
        self.state, self.valve_mode = STATE_BY_NUMBER[int(state)], MODE_BY_NUMBER[int(mode)]
