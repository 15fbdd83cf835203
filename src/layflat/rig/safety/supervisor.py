"""The supervisor: outside the controller, it decides in every cycle whether the rig moves, holds or lets out its air.

A cycle of a rig in motion is one call of compiled code (cycle.py). Python decides only where something changes: a
request, a fault, a lost reply, or a state that time leads on from; the stages are then performed one by one.
"""

from collections.abc import Sequence
from math import isnan
from typing import NamedTuple

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.rig.abilities import falls
from layflat.rig.driver import DeviceState, Reading
from layflat.rig.law import ArmLaw
from layflat.rig.safety.core import Core
from layflat.rig.safety.cycle_numbers import BAD, CHANGED, CONTROL, DEMAND, DOUBTED, ESTIMATE, FOUND, GATE, JUDGE
from layflat.rig.safety.demands import REFUSED
from layflat.rig.safety.faults import Fault, Reaction
from layflat.rig.safety.state_machine import StateMachine
from layflat.rig.safety.states import State, ValveMode

MOVE = DEMAND | ESTIMATE | CONTROL  # stages of a cycle in which something was read, after it was judged


class HostRequest(NamedTuple):
    """Request of the host in a cycle."""

    demands: list[float]  # rad; not a number where there is none yet
    start: bool = False  # edge: bring the air and obey demands
    stop: bool = False  # edge: hold, then let out the air
    reset: bool = False  # edge: latched faults may go
    age: float = 0.0  # since the host was last heard, s
    velocities: Sequence[float] | None = None  # rad/s; None, or not a number: derived from the demands, as the next
    accelerations: Sequence[float] | None = None  # rad/s2
    since: float = 0.0  # the instant for which the demands are meant, s
    hold: bool = False  # edge: hold the joints where they are, with air; a start goes on
    switched: Sequence[tuple[int, bool]] = ()  # edges: digital outputs by number, and whether they are on from now on


class Supervisor(StateMachine):
    """State, faults and what is done about them, of a machine with valve and sensors and the law that controls it."""

    def __init__(self, machine: Machine, law: ArmLaw) -> None:
        core = Core(machine, law)
        super().__init__(machine, core)
        self.lost = 0  # replies that were lost, one after the other
        self.outputs = 0  # digital outputs that are on, as bits
        self._stale_after = machine.safety.setpoint_age - machine.cycle
        self._low, self._high = core.rig["voltage_low"][0], core.rig["voltage_high"][0]
        self._centre = core.rig["centre"][0]
        self._vented = self._centre if falls(machine) else self._high  # of valves that let out the air
        # What the controllers are given (rad), and what may be sent (V), (joints,); the arrays stay the same.
        self.demands, self.voltages = core.demands, core.voltages
        self.noted: tuple[Fault, ...] = ()  # that the loop found in this cycle: a missed one, or a dead recorder

    def begin(self, reading: Reading, *, filled: bool = False) -> None:
        """Start from a first reading; `filled`: air is there already, as in a simulated run, and demands are obeyed."""
        self.core.begin(reading, filled=filled)
        self.core.freeze(reading.angles)
        if filled:
            self.enter(State.READY, ValveMode.HOLD)
            self.core.wake(reading)
            self.wake = False

    def cycle(self, reading: Reading | None, request: HostRequest, elapsed: float, since: float) -> None:
        """One control cycle, which leaves `demands`, `voltages`, `air` and `resets` as they are to be.

        The reading is None where the reply was lost; times are since the last samples and since the last cycle, s.
        """
        self.ledger.new_cycle()
        for number, on in request.switched:
            self.outputs = self.outputs & ~(1 << number) | on << number
        core = self.core
        core.ask(request.demands, request.velocities, request.accelerations, request.since)
        if reading is not None:
            core.take(reading)
            self.lost = 0
            if not self._goes_on(reading, request):
                self._judge(reading, elapsed)
            elif (came := self._perform(JUDGE | MOVE | GATE, reading.supply, elapsed, since)) & FOUND:
                self._note_found()
            else:
                self.pass_time(since)
                self._note_changes(came)
                return
        else:
            self.ledger.note(Fault.REPLY_LOST)
            self.lost += 1
            if self.lost >= Fault.LINK_LOST.cycles:
                self.ledger.note(Fault.LINK_LOST)
        for fault in self.noted:
            self.ledger.note(fault)
        self.pass_time(since)
        self._decide(request)
        supply = reading.supply if reading is not None else 0.0
        stages = MOVE if reading is not None else DEMAND
        self._note_changes(self._perform(stages | (GATE if self.air else 0), supply, elapsed, since))
        if not self.air:
            self._without_air(self.voltages)

    def _goes_on(self, reading: Reading, request: HostRequest) -> bool:
        """True if all that was so in the cycle before is still so, as far as it can be told before it is judged."""
        return (
            self.state is State.MOVING
            and not (request.start or request.stop or request.reset or request.hold)
            and not (reading.stopped or self._reset_for)
            and not (self.noted or self.ledger.latched)
            and reading.device == DeviceState.RUNNING
            and request.age <= self._stale_after
        )

    def _perform(self, stages: int, supply: float, elapsed: float, since: float) -> int:
        follow = self.valve_mode is ValveMode.FOLLOW
        came = self.core.perform(stages, supply, elapsed, since, self.level, follow=follow, wake=self.wake)
        if stages & CONTROL and not came & FOUND:
            self.wake = False
        return came

    def _judge(self, reading: Reading, elapsed: float) -> None:
        """Look at what was read, and note every fault."""
        self.pressed = reading.stopped
        if reading.stopped:
            self.ledger.note(Fault.E_STOP)
        if reading.device == DeviceState.DUMPED:
            self.outputs = 0  # as the device's are: none comes on by itself once it obeys again
        self.device_state(reading.device)
        if self._perform(JUDGE, reading.supply, elapsed, 0.0):
            self._note_found()
        if self.state is State.STARTING:
            self.starting(reading.supply, elapsed)

    def _note_found(self) -> None:
        """Note what the detectors found."""
        fault, faults = self.core.found
        if fault:
            self.ledger.note(fault)
        for j, found in enumerate(faults):
            if found:
                self.ledger.note(found, j)

    def _decide(self, request: HostRequest) -> None:
        """Decide on state and valve mode."""
        running = self.air
        if request.age > self._stale_after and running:
            self.ledger.note(Fault.SETPOINT_STALE)
            self.stop()
        if request.reset:
            self.reset()
        if request.stop:
            if running:
                self.stop()
        elif request.hold:
            self.hold()
        elif request.start:
            self.start()
        if self.ledger.latched:
            self.react()
        self.go_on()
        if self.state is State.READY and not all(isnan(demand) for demand in request.demands):
            self.enter(State.MOVING, ValveMode.FOLLOW)

    def _note_changes(self, came: int) -> None:
        """Note demands that were changed, a law that gave up, and voltages that may not be sent."""
        if came & DOUBTED:
            self.ledger.note(Fault.MODEL_DOUBTED)
        if came & CHANGED:
            for j, outcome in enumerate(self.core.outcomes.tolist()):
                if outcome:
                    self.ledger.note(Fault.DEMAND_REFUSED if outcome == REFUSED else Fault.DEMAND_LIMITED, j)
        if came & BAD:
            for j, volts in enumerate(self.core.voltages_asked.tolist()):
                if not self._low <= volts <= self._high:
                    self.ledger.note(Fault.BAD_COMMAND, j)
            self.react(self.demands)
            self.wake = True

    def _without_air(self, out: Array) -> None:
        """Voltages of valves behind a line that is let out."""
        out.fill(self._vented if self.valve_mode is ValveMode.VENT else self._centre)
        if self.valve_mode is ValveMode.VENT_JOINT:
            for j, fault in enumerate(self.ledger.joints):
                if fault.reaction is Reaction.VENT_JOINT:
                    out[j] = self._vented
        elif self.valve_mode is ValveMode.CENTRE and self.ledger.latched >= Fault.VALVE_UNRESPONSIVE:
            for j, fault in enumerate(self.ledger.joints):
                if fault is Fault.VALVE_UNRESPONSIVE:
                    # One hose may be burst: the other throws the joint into its stop, unless it is let out at once.
                    out[j] = self._low if self.core.pressures[j] > 0.0 else self._high
