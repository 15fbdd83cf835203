"""Supervisor: outside the controller, it decides in every cycle whether the rig moves, holds or vents its hoses.

A cycle of a rig in motion is one call of compiled code (cycle.py). Python decides only where something changes: a
request, a fault, a lost reply, or a state that ends by time; the stages are then performed one by one.
"""

from collections.abc import Sequence
from math import isnan
from typing import NamedTuple

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.rig.abilities import falls_without_air
from layflat.rig.driver import DeviceState, SensorReading
from layflat.rig.law import ArmLaw
from layflat.rig.safety.core import CycleCore
from layflat.rig.safety.cycle_numbers import (
    CONTROL_STAGE,
    DEMAND_CHANGED,
    DEMAND_STAGE,
    ESTIMATE_STAGE,
    FAULT_DETECTED,
    GATE_STAGE,
    JUDGE_STAGE,
    MODEL_REJECTED,
    VOLTAGE_REFUSED,
)
from layflat.rig.safety.demands import DEMAND_REFUSED
from layflat.rig.safety.faults import Fault, Reaction, RigState, ValveMode
from layflat.rig.safety.state_machine import StateMachine

MOTION_STAGES = (
    DEMAND_STAGE | ESTIMATE_STAGE | CONTROL_STAGE
)  # stages of a cycle in which something was read, after it was judged


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


class Supervisor(StateMachine):
    """Supervisor of a machine with valve and sensors, and of its control law: states, faults and reactions."""

    def __init__(self, machine: Machine, law: ArmLaw) -> None:
        core = CycleCore(machine, law)
        super().__init__(machine, core)
        self.lost = 0  # replies lost in succession
        self.outputs = 0  # digital outputs that are on, as bits
        self._stale_after = machine.safety.setpoint_age - machine.cycle
        self._low, self._high = core.rig["voltage_low"][0], core.rig["voltage_high"][0]
        self._centre = core.rig["centre"][0]
        self._vented = self._centre if falls_without_air(machine) else self._high  # voltage of valves that are vented
        # Demands of the controllers (rad) and voltages to send (V), (joints,); the arrays stay the same.
        self.demands, self.voltages = core.demands, core.voltages
        self.noted: tuple[Fault, ...] = ()  # faults of this cycle from the loop: a missed cycle, a dead recorder

    def initialize(self, reading: SensorReading, *, filled: bool = False) -> None:
        """Initialize with a first reading.

        Args:
            reading: first reading of the sensors.
            filled: whether air is on already, as in a simulated run, so that demands are obeyed at once.
        """
        self.core.initialize_air(reading, filled=filled)
        self.core.freeze(reading.angles)
        if filled:
            self.enter(RigState.READY, ValveMode.HOLD)
            self.core.wake(reading)
            self.wake = False

    def cycle(self, reading: SensorReading | None, request: HostRequest, elapsed: float, since: float) -> None:
        """Perform one control cycle, which sets `demands`, `voltages`, `outputs`, and the state of air and reset bit.

        Args:
            reading: reading of the sensors; None where the reply was lost.
            request: request of the host.
            elapsed: time since the last samples, s.
            since: time since the last cycle, s.
        """
        self.ledger.new_cycle()
        for number, on in request.switched:
            self.outputs = self.outputs & ~(1 << number) | on << number
        core = self.core
        core.load_demands(request.demands, request.velocities, request.accelerations, request.since)
        if reading is not None:
            core.load_reading(reading)
            self.lost = 0
            if not self._is_unchanged(reading, request):
                self._evaluate_reading(reading, elapsed)
            elif (
                outcomes := self._perform(JUDGE_STAGE | MOTION_STAGES | GATE_STAGE, reading.supply, elapsed, since)
            ) & FAULT_DETECTED:
                self._record_faults()
            else:
                self.pass_time(since)
                self._note_changes(outcomes)
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
        stages = MOTION_STAGES if reading is not None else DEMAND_STAGE
        self._note_changes(self._perform(stages | (GATE_STAGE if self.is_pressurised else 0), supply, elapsed, since))
        if not self.is_pressurised:
            self._write_voltages_without_air(self.voltages)

    def _is_unchanged(self, reading: SensorReading, request: HostRequest) -> bool:
        """Return whether the rig is moving and nothing but the detectors can change its state in this cycle."""
        return (
            self.state is RigState.MOVING
            and not (request.start or request.stop or request.reset or request.hold)
            and not (reading.stopped or self._reset_for)
            and not (self.noted or self.ledger.latched)
            and reading.device == DeviceState.RUNNING
            and request.age <= self._stale_after
        )

    def _perform(self, stages: int, supply: float, elapsed: float, since: float) -> int:
        """Perform stages of the control cycle in the present mode of the valves, and return flags of their outcomes.

        `elapsed` is the time since the last samples, `since` that since the last cycle, s.
        """
        follow = self.valve_mode is ValveMode.FOLLOW
        outcomes = self.core.perform(stages, supply, elapsed, since, self.level, follow=follow, wake=self.wake)
        if stages & CONTROL_STAGE and not outcomes & FAULT_DETECTED:
            self.wake = False
        return outcomes

    def _evaluate_reading(self, reading: SensorReading, elapsed: float) -> None:
        """Note every fault of a reading (e-stop, device state, detectors); continue a soft start.

        The outputs are switched off after a dump; `elapsed` is the time since the last samples, s.
        """
        self.pressed = reading.stopped
        if reading.stopped:
            self.ledger.note(Fault.E_STOP)
        if reading.device == DeviceState.DUMPED:
            self.outputs = 0  # as the device's are: none switches on by itself once it obeys again
        self.device_state(reading.device)
        if self._perform(JUDGE_STAGE, reading.supply, elapsed, 0.0):
            self._record_faults()
        if self.state is RigState.STARTING:
            self.starting(reading.supply, elapsed)

    def _record_faults(self) -> None:
        """Note in the ledger the faults that the last detection has found in the rig and in its joints."""
        fault, faults = self.core.detected_faults
        if fault:
            self.ledger.note(fault)
        for j, joint_fault in enumerate(faults):
            if joint_fault:
                self.ledger.note(joint_fault, j)

    def _decide(self, request: HostRequest) -> None:
        """Apply the host's request and the reactions to faults: change the state, and the mode of the valves.

        Stale setpoints under air begin a controlled stop; in READY, a demand for any joint begins the motion.
        """
        running = self.is_pressurised
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
        self.continue_stop()
        if self.state is RigState.READY and not all(isnan(demand) for demand in request.demands):
            self.enter(RigState.MOVING, ValveMode.FOLLOW)

    def _note_changes(self, outcomes: int) -> None:
        """Note demands that were limited or refused, a law that gave up, and voltages out of range.

        After such a voltage it performs the reaction, which holds the joints, and initializes the controllers anew.
        """
        if outcomes & MODEL_REJECTED:
            self.ledger.note(Fault.MODEL_DOUBTED)
        if outcomes & DEMAND_CHANGED:
            for j, outcome in enumerate(self.core.outcomes.tolist()):
                if outcome:
                    self.ledger.note(Fault.DEMAND_REFUSED if outcome == DEMAND_REFUSED else Fault.DEMAND_LIMITED, j)
        if outcomes & VOLTAGE_REFUSED:
            for j, volts in enumerate(self.core.law_voltages.tolist()):
                if not self._low <= volts <= self._high:
                    self.ledger.note(Fault.BAD_COMMAND, j)
            self.react(self.demands)
            self.wake = True

    def _write_voltages_without_air(self, out: Array) -> None:
        """Write the voltages of the valves by their mode, without air, into an array, V, (joints,).

        VENT_JOINT vents only faulty joints; CENTRE vents the fuller hose of joints whose valve is unresponsive.
        """
        out.fill(self._vented if self.valve_mode is ValveMode.VENT else self._centre)
        if self.valve_mode is ValveMode.VENT_JOINT:
            for j, fault in enumerate(self.ledger.joints):
                if fault.reaction is Reaction.VENT_JOINT:
                    out[j] = self._vented
        elif self.valve_mode is ValveMode.CENTRE and self.ledger.latched >= Fault.VALVE_UNRESPONSIVE:
            for j, fault in enumerate(self.ledger.joints):
                if fault is Fault.VALVE_UNRESPONSIVE:
                    # One hose may be burst: the other throws the joint into its stop unless it is vented at once.
                    out[j] = self._low if self.core.pressures[j] > 0.0 else self._high
