"""States of a rig, and what leads from one to another: the host's requests, faults, and time."""

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.rig.abilities import vent_time
from layflat.rig.driver import DeviceState
from layflat.rig.safety.core import Core
from layflat.rig.safety.detectors.sample import AIR as ALL
from layflat.rig.safety.detectors.sample import MOTION, SENSORS
from layflat.rig.safety.faults import Fault, Ledger, Reaction
from layflat.rig.safety.states import AIR, State, ValveMode

# Cycles for which a reset is not sent, and then is: the device takes its edge, also if one reply is lost.
RESET_LOW, RESET_HIGH = 4, 4
THERE = 0.2  # supply and ripple have to be there for so long until a soft start is over, s
FILLS = 0.7  # of the time of a soft start: so long it waits for hoses to fill; valves that leak little never fill them
# Before valves are opened to let out the air they are centred: until the supply line is empty, and joints have come to
# rest between hoses that are shut, s.
CENTRED = 0.3


class StateMachine:
    """Where a rig stands, and what is done with its valves."""

    def __init__(self, machine: Machine, core: Core) -> None:
        self.safety, self.core = machine.safety, core
        self.ledger = Ledger(list(machine.joints))
        self._ready = machine.supply.ambient_pressure + machine.safety.supply_ready * machine.supply.pressure_gauge
        self._vent_time = vent_time(machine)
        self.state, self.valve_mode = State.OFF, ValveMode.CENTRE
        self.wake = True  # whether the controllers have to begin anew in this cycle
        self.barred = False  # whether no start is allowed, since nothing is recorded
        self.pressed = False  # whether the e-stop is pressed
        self._in_state = self._in_mode = self._there_for = 0.0
        self._reset_for = 0
        self._obeyed = False

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
        return self.state is State.OFF or (not AIR[self.valve_mode] and self._in_mode >= self._vent_time)

    def pass_time(self, elapsed: float) -> None:
        """Let a cycle of `elapsed` seconds pass."""
        self._in_state += elapsed
        self._in_mode += elapsed
        if self._reset_for:
            self._reset_for -= 1

    @property
    def level(self) -> float:
        """What there is to watch (see detectors/sample.py)."""
        if not AIR[self.valve_mode]:
            return SENSORS
        return MOTION if self.state is State.STARTING else ALL

    def enter(self, state: State, mode: ValveMode) -> None:
        """Be in a state, with the valves in a mode."""
        if state is not self.state:
            self.ledger.events.append(f"{self.state.name.lower()} -> {state.name.lower()}")
            self.state, self._in_state = state, 0.0
        if mode is not self.valve_mode:
            if AIR[mode] and not AIR[self.valve_mode]:
                self.wake = True
                self.core.reset()
            self.valve_mode, self._in_mode = mode, 0.0

    def device_state(self, device: DeviceState) -> None:
        """Note what the device does by itself."""
        if not AIR[self.valve_mode]:
            return
        if device == DeviceState.RUNNING:
            self._obeyed = True
        elif self._obeyed:
            self.ledger.note(Fault.DEVICE_DUMPED if device == DeviceState.DUMPED else Fault.DEVICE_CENTRED)

    def starting(self, supply: float, elapsed: float) -> None:
        """Look whether a soft start is over, or takes too long; `supply` absolute, Pa, `elapsed` in s."""
        filled = self.core.hoses_are_filled(supply) or self._in_state > FILLS * self.safety.start_time
        self._there_for = self._there_for + elapsed if self.core.air_is_there(supply, self._ready) else 0.0
        if self._there_for >= THERE and filled:
            self.core.reset()
            self.enter(State.READY, ValveMode.HOLD)
        elif self._in_state > self.safety.start_time:
            self.ledger.note(Fault.NO_AIR)

    def start(self) -> None:
        """Bring the air, or go on with it."""
        if self.ledger.latched or self.pressed:
            self.ledger.events.append("no start: a fault is latched; give a reset first")
        elif self.barred:
            self.ledger.events.append("no start: nothing is recorded")
        elif self.state is State.HOLDING and AIR[self.valve_mode]:
            self.enter(State.READY, ValveMode.HOLD)
        elif self.state in {State.OFF, State.STOPPED}:
            self.core.freeze()
            self._obeyed, self._reset_for, self._there_for = False, RESET_LOW + RESET_HIGH, 0.0
            self.enter(State.STARTING, ValveMode.HOLD)

    def hold(self) -> None:
        """Hold joints that demands move, or could."""
        if self.state in {State.READY, State.MOVING}:
            self.core.freeze()
            self.enter(State.HOLDING, ValveMode.HOLD)

    def stop(self) -> None:
        """Controlled stop: the joints are held, then the air is let out."""
        if self.state is State.FAULT:
            self.ledger.reaction = max(self.ledger.reaction, Reaction.STOP)
        elif self.state is State.STARTING:
            self.enter(State.STOPPED, ValveMode.CENTRE)
        elif self.state is not State.STOPPED:
            if self.valve_mode is not ValveMode.HOLD or self.state is not State.HOLDING:
                self.core.freeze()
            self.enter(State.STOPPED, ValveMode.HOLD)
            self._in_mode = 0.0

    def reset(self) -> None:
        """Let go of latched faults that are over."""
        if self.pressed or (self.ledger.now >= Fault.DEVICE_CENTRED and AIR[self.valve_mode]):
            self.ledger.events.append("no reset: the fault is still there")
            return
        self.ledger.clear()
        self._reset_for = RESET_LOW + RESET_HIGH
        if self.state is State.FAULT:
            self.core.reset()
            self.core.freeze()
            held = AIR[self.valve_mode]
            self.enter(State.HOLDING if held else State.OFF, self.valve_mode if held else ValveMode.CENTRE)

    def react(self, angles: Array | None = None) -> None:
        """Do what the worst of the latched faults asks for; air that is off stays off."""
        reaction, on = self.ledger.reaction, AIR[self.valve_mode]
        if self.valve_mode is ValveMode.FOLLOW or (on and self.state is not State.FAULT):
            self.core.freeze(angles)
        mode = self.valve_mode
        if on:
            # Air that can't get out brakes best: valves open once the supply line is empty.
            mode = ValveMode.CENTRE if reaction >= Reaction.VENT_JOINT else ValveMode.HOLD
        elif mode is ValveMode.VENT_JOINT and reaction >= Reaction.VENT:
            mode = ValveMode.VENT
        self.enter(State.FAULT, mode)

    def go_on(self) -> None:
        """What time brings of a stop: held, centred, vented."""
        reaction = self.ledger.reaction if self.state is State.FAULT else Reaction.STOP
        if self.state not in {State.STOPPED, State.FAULT} or reaction < Reaction.STOP:
            return
        if self.valve_mode is ValveMode.HOLD and self._in_mode >= self.safety.hold_time:
            self.enter(self.state, ValveMode.CENTRE)
        elif self.valve_mode is ValveMode.CENTRE and self._in_mode >= CENTRED:
            self.enter(self.state, ValveMode.VENT_JOINT if reaction is Reaction.VENT_JOINT else ValveMode.VENT)
