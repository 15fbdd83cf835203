"""The supervisor: outside the controller, it decides in every cycle whether the rig moves, holds or lets out its air.

In a cycle the loop lets it `judge` what was read (or calls `lost`), `steer` by what the host wants, steps the
controllers with its `demands`, and lets it `gate` the voltages.
"""

from __future__ import annotations

from math import isfinite, isnan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.control import watch
from layflat.machine import Machine
from layflat.machine.parameters.drives import drive_parts
from layflat.rig.driver import DeviceState, Reading
from layflat.rig.safety.debounce import CountDebounce, TimeDebounce
from layflat.rig.safety.demands import DemandGate
from layflat.rig.safety.faults import REACTIONS, TABLE, Fault, Reaction
from layflat.rig.safety.ledger import Ledger
from layflat.rig.safety.limits import limits
from layflat.rig.safety.machine_watch import MachineWatch
from layflat.rig.safety.states import AIR, State, ValveMode

Array = NDArray[np.float64]

RESET_LOW, RESET_HIGH = 4, 4
"""Cycles for which a reset is not sent, and then is: the device takes its edge, also if one reply is lost."""

THERE = 0.2
"""Supply and ripple have to be there for so long until a soft start is over, s."""

FILLS = 0.7
"""Of the time of a soft start: so long it waits for hoses to fill; valves that leak little never fill them."""

CENTRED = 0.3
"""Before valves are opened to let out the air they are centred: until the supply line is empty, and joints have come to
rest between hoses that are shut, s."""


class HostRequest(NamedTuple):
    """What the host wants in a cycle."""

    demands: list[float]
    """rad; not a number where there is none yet."""
    start: bool = False
    """Edge: bring the air and obey demands."""
    stop: bool = False
    """Edge: hold, then let out the air."""
    reset: bool = False
    """Edge: latched faults may go."""
    age: float = 0.0
    """Since the host was last heard, s."""


class Supervisor:
    """State, faults and what is done about them.

    Args:
        machine: with valve, sensors and controller.
        cycle: of the loop, s.

    Raises:
        MachineError: the machine has no valve or sensors.
    """

    def __init__(self, machine: Machine, cycle: float) -> None:
        valve, _, _ = drive_parts(machine)
        self.safety = machine.safety
        each = [limits(machine, name) for name in machine.joints]
        self.watch = MachineWatch(machine, cycle, each)
        self.gates = [
            DemandGate(
                0.5 * joint.stops.working_stroke, 0.5 * joint.stops.mechanical_stroke, machine.safety.demand_speed
            )
            for joint in machine.joints.values()
        ]
        self.ledger = Ledger(list(machine.joints))
        self._centre = valve.centre_voltage
        self._low, self._high = valve.centre_voltage - valve.volts_to_full, valve.centre_voltage + valve.volts_to_full
        self._out = np.full(len(each), self._centre)
        self._lost = CountDebounce(TABLE[Fault.LINK_LOST].cycles)
        self._there = TimeDebounce(THERE, 0.0)
        self._stale_after = machine.safety.setpoint_age - cycle
        self.state, self.valve_mode = State.OFF, ValveMode.CENTRE
        self.demands = np.zeros(len(each))
        """What the controllers are to be given, rad, (joints,); the array stays the same."""
        self.wake = True
        """Whether the controllers have to begin anew in this cycle."""
        self._in_state = self._in_act = 0.0
        self._reset_for = 0
        self._obeyed = self._barred = self._pressed = False
        self._differences = np.zeros(len(each))

    @property
    def air(self) -> bool:
        """Whether the dump valve is to let air in."""
        return AIR[self.valve_mode]

    @property
    def resets(self) -> bool:
        """Whether the device is to be told to obey again."""
        return 0 < self._reset_for <= RESET_HIGH

    @property
    def empty(self) -> bool:
        """Whether the air is off and has had the time to leave the hoses."""
        return self.state is State.OFF or (not AIR[self.valve_mode] and self._in_act >= self.safety.vent_time)

    def begin(self, reading: Reading, *, filled: bool = False) -> None:
        """Start from a first reading; `filled`: air is there already, as in a simulated run, and demands are obeyed."""
        self.watch.begin(reading, filled=filled)
        self._freeze(reading.angles.tolist())
        if filled:
            self._enter(State.READY, ValveMode.HOLD)
            self.wake = False

    def judge(self, reading: Reading, status: Array, memory: Array, voltages: Array, elapsed: float) -> None:
        """Look at what was read (see `MachineWatch.look`), and note every fault."""
        note = self.ledger.note
        self.ledger.new_cycle()
        self._lost(False)
        self._pressed, self._differences = reading.stopped, reading.pressures
        if reading.stopped:
            note(Fault.E_STOP)
        self._device_state(reading.device)
        level = self._level()
        lead = max([gate.ahead for gate in self.gates])
        fault = self.watch.look(reading, status, memory, voltages, self.demands, lead, elapsed, level)
        if fault:
            note(fault)
        for j, found in enumerate(self.watch.found):
            if found:
                self.ledger.note_joint(j, found)
        if self.state is State.STARTING:
            self._starting(reading, elapsed)

    def lost(self) -> None:
        """A cycle without a reply."""
        self.ledger.new_cycle()
        self.ledger.note(Fault.REPLY_LOST)
        if self._lost(True):
            self.ledger.note(Fault.LINK_LOST)

    def tell(self, fault: Fault, *, is_so: bool) -> None:
        """Note what others found: the loop that a cycle was missed, or that the recorder is dead."""
        if fault is Fault.RECORDER_DEAD:
            self._barred = is_so
        if is_so:
            self.ledger.note(fault)

    def steer(self, wish: HostRequest, angles: list[float], elapsed: float) -> None:
        """Decide on state, act and demands.

        Args:
            wish: of the host.
            angles: where the joints are (averaged), rad, in case that they are to be held.
            elapsed: s.
        """
        self._in_state += elapsed
        self._in_act += elapsed
        self._reset_for = max(self._reset_for - 1, 0)
        running = AIR[self.valve_mode]
        if wish.age > self._stale_after and running:
            self.ledger.note(Fault.SETPOINT_STALE)
            self._stop(angles)
        if wish.reset:
            self._reset(angles)
        if wish.stop and running:
            self._stop(angles)
        if wish.start and not wish.stop:
            self._start(angles)
        if self.ledger.latched:
            self._react(angles)
        self._go_on()
        self._demand(wish, elapsed)

    def gate(self, voltages: Array) -> Array:
        """Voltages that may be sent, V, (joints,); the array is used again in the next cycle."""
        out, act = self._out, self.valve_mode
        if not AIR[act]:
            return self._without_air(out)
        bad = False
        for j, volts in enumerate(voltages.tolist()):
            # Written so that what is not a number is refused.
            if self._low <= volts <= self._high:
                out[j] = volts
            else:
                bad = True
                self.ledger.note_joint(j, Fault.BAD_COMMAND)
        if bad:
            # All of them: a joint that is held by its controller is shaken by one that is not, and shakes it.
            out.fill(self._centre)
            self._react([gate.demand for gate in self.gates])
            self.wake = True
        return out

    def _without_air(self, out: Array) -> Array:
        out.fill(self._high if self.valve_mode is ValveMode.VENT else self._centre)
        if self.valve_mode is ValveMode.VENT_JOINT:
            for j, fault in enumerate(self.ledger.joints):
                if REACTIONS[fault] is Reaction.VENT_JOINT:
                    out[j] = self._high
        elif self.valve_mode is ValveMode.CENTRE and self.ledger.latched >= Fault.VALVE_UNRESPONSIVE:
            for j, fault in enumerate(self.ledger.joints):
                if fault is Fault.VALVE_UNRESPONSIVE:
                    # One hose may be burst: the other throws the joint into its stop, unless it is let out at once.
                    out[j] = self._low if self._differences[j] > 0.0 else self._high
        return out

    # States

    def _enter(self, state: State, act: ValveMode) -> None:
        if state is not self.state:
            self.ledger.say(f"{self.state.name.lower()} -> {state.name.lower()}")
            self.state, self._in_state = state, 0.0
        if act is not self.valve_mode:
            if AIR[act] and not AIR[self.valve_mode]:
                self.wake = True
                self.watch.reset()
            self.valve_mode, self._in_act = act, 0.0

    def _freeze(self, angles: list[float]) -> None:
        for j, (gate, angle) in enumerate(zip(self.gates, angles, strict=True)):
            gate.freeze(angle if isfinite(angle) else gate.demand)
            self.demands[j] = gate.demand

    def _level(self) -> int:
        if not AIR[self.valve_mode]:
            return watch.SENSORS
        return watch.MOTION if self.state is State.STARTING else watch.AIR

    def _device_state(self, device: DeviceState) -> None:
        if not AIR[self.valve_mode]:
            return
        if device == DeviceState.RUNNING:
            self._obeyed = True
        elif self._obeyed:
            self.ledger.note(Fault.DEVICE_DUMPED if device == DeviceState.DUMPED else Fault.DEVICE_CENTRED)

    def _starting(self, reading: Reading, elapsed: float) -> None:
        filled = self.watch.hoses_are_filled(reading.supply) or self._in_state > FILLS * self.safety.start_time
        if self._there(self.watch.air_is_there(reading), elapsed) and filled:
            self.watch.reset()
            self._enter(State.READY, ValveMode.HOLD)
        elif self._in_state > self.safety.start_time:
            self.ledger.note(Fault.NO_AIR)

    def _start(self, angles: list[float]) -> None:
        if self.ledger.latched or self._pressed:
            self.ledger.say("no start: a fault is latched; give a reset first")
        elif self._barred:
            self.ledger.say("no start: nothing is recorded")
        elif self.state is State.HOLDING and AIR[self.valve_mode]:
            self._enter(State.READY, ValveMode.HOLD)
        elif self.state in {State.OFF, State.STOPPED}:
            self._freeze(angles)
            self._obeyed, self._reset_for = False, RESET_LOW + RESET_HIGH
            self._there(False, 0.0)
            self._enter(State.STARTING, ValveMode.HOLD)

    def _stop(self, angles: list[float]) -> None:
        """Controlled stop: the joints are held, then the air is let out."""
        if self.state is State.FAULT:
            self.ledger.worsen(Reaction.STOP)
        elif self.state is State.STARTING:
            self._enter(State.STOPPED, ValveMode.CENTRE)
        elif self.state is not State.STOPPED:
            if self.valve_mode is not ValveMode.HOLD or self.state is not State.HOLDING:
                self._freeze(angles)
            self._enter(State.STOPPED, ValveMode.HOLD)
            self._in_act = 0.0

    def _reset(self, angles: list[float]) -> None:
        if self._pressed or (self.ledger.now >= Fault.DEVICE_CENTRED and AIR[self.valve_mode]):
            self.ledger.say("no reset: the fault is still there")
            return
        self.ledger.clear()
        self._reset_for = RESET_LOW + RESET_HIGH
        if self.state is State.FAULT:
            self.watch.reset()
            self._freeze(angles)
            self._enter(
                State.HOLDING if AIR[self.valve_mode] else State.OFF,
                self.valve_mode if AIR[self.valve_mode] else ValveMode.CENTRE,
            )

    def _react(self, angles: list[float]) -> None:
        """Do what the worst of the latched faults asks for; air that is off stays off."""
        reaction, on = self.ledger.reaction, AIR[self.valve_mode]
        if self.valve_mode is ValveMode.FOLLOW or (on and self.state is not State.FAULT):
            self._freeze(angles)
        act = self.valve_mode
        if on:
            # Air that can't get out brakes best: valves open once the supply line is empty.
            act = ValveMode.CENTRE if reaction >= Reaction.VENT_JOINT else ValveMode.HOLD
        elif act is ValveMode.VENT_JOINT and reaction >= Reaction.VENT:
            act = ValveMode.VENT
        self._enter(State.FAULT, act)

    def _go_on(self) -> None:
        """What time brings of a stop: held, centred, vented."""
        reaction = self.ledger.reaction if self.state is State.FAULT else Reaction.STOP
        if self.state not in {State.STOPPED, State.FAULT} or reaction < Reaction.STOP:
            return
        if self.valve_mode is ValveMode.HOLD and self._in_act >= self.safety.hold_time:
            self._enter(self.state, ValveMode.CENTRE)
        elif self.valve_mode is ValveMode.CENTRE and self._in_act >= CENTRED:
            self._enter(self.state, ValveMode.VENT_JOINT if reaction is Reaction.VENT_JOINT else ValveMode.VENT)

    def _demand(self, wish: HostRequest, elapsed: float) -> None:
        if self.state is State.READY and not all(isnan(demand) for demand in wish.demands):
            self._enter(State.MOVING, ValveMode.FOLLOW)
        if self.valve_mode is ValveMode.FOLLOW:
            margin = min([gate.margin(asked) for gate, asked in zip(self.gates, wish.demands, strict=True)])
            lead = min(self.safety.demand_lead, self.safety.demand_margin * max(margin, 0.0))
            for j, (gate, asked) in enumerate(zip(self.gates, wish.demands, strict=True)):
                self.demands[j] = gate.follow(asked, lead, elapsed)
                if gate.refused:
                    self.ledger.note_joint(j, Fault.DEMAND_REFUSED)
                elif gate.limited:
                    self.ledger.note_joint(j, Fault.DEMAND_LIMITED)
        else:
            for gate in self.gates:
                gate.settle(elapsed)
