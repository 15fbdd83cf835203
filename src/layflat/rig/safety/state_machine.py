"""State machine of a rig; requests of the host, faults, and time cause its transitions."""

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.rig.abilities import vent_time
from layflat.rig.driver import DeviceState
from layflat.rig.safety.core import CycleCore
from layflat.rig.safety.detectors.sample import AIR_LEVEL as ALL
from layflat.rig.safety.detectors.sample import MOTION_LEVEL, SENSORS_LEVEL
from layflat.rig.safety.faults import MODE_HAS_AIR, Fault, FaultLedger, Reaction, RigState, ValveMode

# Cycles for which the reset bit is low, then high: the device detects the edge, even if one reply is lost.
RESET_LOW_CYCLES, RESET_HIGH_CYCLES = 4, 4
AIR_READY_TIME = 0.2  # for which supply and ripple have to be sufficient before a soft start is over, s
FILL_TIME_FRACTION = 0.7  # of start_time, after which filled hoses are no longer required: valves may leak too little
# Valves are centred for so long before they open to vent the hoses: until the supply line is empty, and the joints
# have come to rest between closed hoses, s.
CENTRED_TIME = 0.3


class StateMachine:
    """States of a rig and modes of its valves."""

    def __init__(self, machine: Machine, core: CycleCore) -> None:
        self.safety, self.core = machine.safety, core
        self.ledger = FaultLedger(list(machine.joints))
        self._ready = machine.supply.ambient_pressure + machine.safety.supply_ready * machine.supply.pressure_gauge
        self._vent_time = vent_time(machine)
        self.state, self.valve_mode = RigState.OFF, ValveMode.CENTRE
        self.wake = True  # whether the controllers are initialized anew in this cycle
        self.barred = False  # whether no start is allowed, since nothing is recorded
        self.pressed = False  # whether the e-stop is pressed
        self._in_state = self._in_mode = self._there_for = 0.0
        self._reset_for = 0
        self._obeyed = False

    @property
    def is_pressurised(self) -> bool:
        """Return whether the dump valve is to connect the supply."""
        return MODE_HAS_AIR[self.valve_mode]

    @property
    def is_reset_bit_set(self) -> bool:
        """Return whether the reset bit of the command is set."""
        return 0 < self._reset_for <= RESET_HIGH_CYCLES

    @property
    def is_vented(self) -> bool:
        """Return whether the air is off and the time for venting the hoses has passed."""
        return self.state is RigState.OFF or (not MODE_HAS_AIR[self.valve_mode] and self._in_mode >= self._vent_time)

    def pass_time(self, elapsed: float) -> None:
        """Advance the times in state and mode by `elapsed` seconds, and the reset bit by a cycle."""
        self._in_state += elapsed
        self._in_mode += elapsed
        if self._reset_for:
            self._reset_for -= 1

    @property
    def level(self) -> float:
        """Return the level of detection: of sensors without air, of motion in a soft start, else all (AIR_LEVEL)."""
        if not MODE_HAS_AIR[self.valve_mode]:
            return SENSORS_LEVEL
        return MOTION_LEVEL if self.state is RigState.STARTING else ALL

    def enter(self, state: RigState, mode: ValveMode) -> None:
        """Enter a state and a mode of the valves; a change of state adds an event.

        A mode that switches the air on resets the detectors, and lets the controllers be initialized anew.
        """
        if state is not self.state:
            self.ledger.events.append(f"{self.state.name.lower()} -> {state.name.lower()}")
            self.state, self._in_state = state, 0.0
        if mode is not self.valve_mode:
            if MODE_HAS_AIR[mode] and not MODE_HAS_AIR[self.valve_mode]:
                self.wake = True
                self.core.reset()
            self.valve_mode, self._in_mode = mode, 0.0

    def device_state(self, device: DeviceState) -> None:
        """Note a fault if the device has centred or dumped by itself while air is on, after it has obeyed once."""
        if not MODE_HAS_AIR[self.valve_mode]:
            return
        if device == DeviceState.RUNNING:
            self._obeyed = True
        elif self._obeyed:
            self.ledger.note(Fault.DEVICE_DUMPED if device == DeviceState.DUMPED else Fault.DEVICE_CENTRED)

    def starting(self, supply: float, elapsed: float) -> None:
        """End a soft start in READY once the air has been there for `AIR_READY_TIME`; note NO_AIR after `start_time`.

        The hoses have to be filled, too, until `FILL_TIME_FRACTION` of that time is over. `supply` is absolute, Pa.
        """
        filled = self.core.hoses_are_filled(supply) or self._in_state > FILL_TIME_FRACTION * self.safety.start_time
        self._there_for = self._there_for + elapsed if self.core.has_air(supply, self._ready) else 0.0
        if self._there_for >= AIR_READY_TIME and filled:
            self.core.reset()
            self.enter(RigState.READY, ValveMode.HOLD)
        elif self._in_state > self.safety.start_time:
            self.ledger.note(Fault.NO_AIR)

    def start(self) -> None:
        """Start softly from OFF or STOPPED, go from HOLDING to READY; without effect in other states.

        If a latched fault, the e-stop or a dead recorder forbids it, it only adds an event.
        """
        if self.ledger.latched or self.pressed:
            self.ledger.events.append("no start: a fault is latched; give a reset first")
        elif self.barred:
            self.ledger.events.append("no start: nothing is recorded")
        elif self.state is RigState.HOLDING and MODE_HAS_AIR[self.valve_mode]:
            self.enter(RigState.READY, ValveMode.HOLD)
        elif self.state in {RigState.OFF, RigState.STOPPED}:
            self.core.freeze()
            self._obeyed, self._reset_for, self._there_for = False, RESET_LOW_CYCLES + RESET_HIGH_CYCLES, 0.0
            self.enter(RigState.STARTING, ValveMode.HOLD)

    def hold(self) -> None:
        """Hold the joints where they are or can stop, from READY or MOVING; without effect in other states."""
        if self.state in {RigState.READY, RigState.MOVING}:
            self.core.freeze()
            self.enter(RigState.HOLDING, ValveMode.HOLD)

    def stop(self) -> None:
        """Begin a controlled stop: hold the joints, centre the valves, then vent (see `continue_stop`).

        A soft start is broken off with centred valves. In FAULT the reaction becomes at least STOP. Without effect in
        STOPPED.
        """
        if self.state is RigState.FAULT:
            self.ledger.reaction = max(self.ledger.reaction, Reaction.STOP)
        elif self.state is RigState.STARTING:
            self.enter(RigState.STOPPED, ValveMode.CENTRE)
        elif self.state is not RigState.STOPPED:
            if self.valve_mode is not ValveMode.HOLD or self.state is not RigState.HOLDING:
                self.core.freeze()
            self.enter(RigState.STOPPED, ValveMode.HOLD)
            self._in_mode = 0.0

    def reset(self) -> None:
        """Clear all latched faults, pulse the reset bit, and leave FAULT for HOLDING where air is on, else OFF.

        With the e-stop pressed, or a fault from DEVICE_CENTRED on present under air, it only adds an event.
        """
        if self.pressed or (self.ledger.now >= Fault.DEVICE_CENTRED and MODE_HAS_AIR[self.valve_mode]):
            self.ledger.events.append("no reset: the fault is still there")
            return
        self.ledger.clear()
        self._reset_for = RESET_LOW_CYCLES + RESET_HIGH_CYCLES
        if self.state is RigState.FAULT:
            self.core.reset()
            self.core.freeze()
            held = MODE_HAS_AIR[self.valve_mode]
            self.enter(RigState.HOLDING if held else RigState.OFF, self.valve_mode if held else ValveMode.CENTRE)

    def react(self, angles: Array | None = None) -> None:
        """Enter FAULT with the valve mode of the worst reaction to latched faults; air that is off stays off.

        Args:
            angles: angles at which the joints are held, rad, (joints,); default: as `CycleCore.freeze`.
        """
        reaction, on = self.ledger.reaction, MODE_HAS_AIR[self.valve_mode]
        if self.valve_mode is ValveMode.FOLLOW or (on and self.state is not RigState.FAULT):
            self.core.freeze(angles)
        mode = self.valve_mode
        if on:
            # Enclosed air brakes best: valves open once the supply line is empty.
            mode = ValveMode.CENTRE if reaction >= Reaction.VENT_JOINT else ValveMode.HOLD
        elif mode is ValveMode.VENT_JOINT and reaction >= Reaction.VENT:
            mode = ValveMode.VENT
        self.enter(RigState.FAULT, mode)

    def continue_stop(self) -> None:
        """Take the next step of a stop once it is due: held, centred, vented."""
        reaction = self.ledger.reaction if self.state is RigState.FAULT else Reaction.STOP
        if self.state not in {RigState.STOPPED, RigState.FAULT} or reaction < Reaction.STOP:
            return
        if self.valve_mode is ValveMode.HOLD and self._in_mode >= self.safety.hold_time:
            self.enter(self.state, ValveMode.CENTRE)
        elif self.valve_mode is ValveMode.CENTRE and self._in_mode >= CENTRED_TIME:
            self.enter(self.state, ValveMode.VENT_JOINT if reaction is Reaction.VENT_JOINT else ValveMode.VENT)
