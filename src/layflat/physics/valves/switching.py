"""Two on/off valves under pulse-width modulation: one fills hose A and vents hose B, the other the reverse.

The driver compares the command with a sawtooth at every instant (natural sampling). A valve's coil has to be charged
before its plunger moves, and to be discharged before it falls back: a pulse shorter than the delay opens nothing, and a
pause shorter than the other delay closes nothing. The plunger travels at constant speed, and stays where it is while
the coil is neither charged nor discharged. Within a step the pulse's edges are exact.

| symbol | meaning | unit |
|---|---|---|
| phase | of the sawtooth at the beginning of a step, 0..1 | 1 |
| D | duty: fraction of the period in which the coil is on | 1 |
| c | charge of the coil, 0..1 | 1 |
| x | opening of the valve, 0..1 | 1 |
| y | remaining travel of the plunger | 1 |
| tau | part of a step in which the coil does not switch | s |
"""

from math import floor, inf
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from layflat.description import units as u
from layflat.jit import composition, law
from layflat.lanes import halves, join, select
from layflat.physics.arrays import itemwise
from layflat.physics.flow import laminar_slope
from layflat.physics.ramp import mean_above_zero
from layflat.physics.valves.kind import ValveKind, ValvePart


class Switch(NamedTuple):
    """Switching times of an on/off valve, s: until its plunger begins to move, and for its full travel."""

    opening_delay: float  # s
    opening_time: float  # s
    closing_delay: float  # s
    closing_time: float  # s


class SwitchingPair(NamedTuple):
    """Parameters of two on/off valves with their driver."""

    switch: Switch
    conductance: float  # of a fully open path, m3/(s Pa)
    leakage: float  # conductance of a closed path, m3/(s Pa)
    critical_ratio: float  # critical pressure ratio
    laminar_slope: float  # slope of the flow near the pressure ratio 1
    centre_voltage: float  # V
    volts_to_full: float  # change of the voltage to full duty, V
    frequency: float  # of the pulses, Hz
    dead_band: float  # command up to which there is no pulse, fraction of full opening
    min_pulse: float  # length of the pulse at the edge of the dead band, s
    delay: float  # from the command to the driver's pulses, s


class SwitchingValvesPart(ValvePart):
    """Description of two on/off valves under pulse-width modulation, with their driver."""

    kind: Literal["switching"]
    frequency: u.ValveFrequency = Field(description="of the pulses")
    dead_band: Annotated[u.Share, Field(lt=0.9)] = Field(description="command up to which there are no pulses")
    min_pulse: u.TimeOrZero = Field(description="length of the pulse at the edge of the dead band")
    opening_delay: u.ShortTime = Field(description="from voltage on to the plunger's first motion")
    opening_time: u.ShortTime = Field(description="of the plunger's full stroke")
    closing_delay: u.ShortTime = Field(description="from voltage off to the plunger's first motion")
    closing_time: u.ShortTime

    @model_validator(mode="after")
    def _check_pulse_period(self) -> Self:
        """Raise ValueError unless the shortest pulse is shorter than the period of the pulses."""
        if self.min_pulse * self.frequency >= 1.0:
            raise ValueError("min_pulse must be shorter than the pulses' period, 1 / frequency")
        return self


def parameters(described: SwitchingValvesPart) -> SwitchingPair:
    """Return the parameters of two on/off valves with their driver."""
    b = described.critical_ratio
    return SwitchingPair(
        Switch(described.opening_delay, described.opening_time, described.closing_delay, described.closing_time),
        described.conductance,
        described.leakage,
        b,
        itemwise(laminar_slope, b),
        described.centre_voltage,
        described.volts_to_full,
        described.frequency,
        described.dead_band,
        described.min_pulse,
        described.delay,
    )


class SwitchState(NamedTuple):
    """State of an on/off valve: charge of its coil, and opening, 0..1."""

    charge: float  # c, 0..1
    opening: float  # x, 0..1


class PairState(NamedTuple):
    """States of the valve that fills hose A, and of the one that vents it."""

    forward: SwitchState
    back: SwitchState


class Carrier(NamedTuple):
    """Sawtooth of the driver: phase at the beginning of the coming step, and phase increment in a step."""

    phase: float  # 0..1
    gain: float  # increment of the phase in a step


@law
def start_carrier(pair, t, h):
    """Return the carrier of the step of h seconds that begins at t, of at most one period per step."""
    cycles = pair.frequency * t
    return Carrier(cycles - floor(cycles), min(pair.frequency * h, 1.0))


@law
def turn_carrier(pair, carrier):  # noqa: ARG001
    """Return the carrier of the next step."""
    phase = carrier.phase + carrier.gain
    return Carrier(phase - floor(phase), carrier.gain)


@law
def duty(pair, command):
    """Return the duty of the valve that a positive command opens: 0 up to the dead band, then `min_pulse` and more."""
    min_duty = pair.frequency * pair.min_pulse
    fraction = (command - pair.dead_band) * (1.0 / (1.0 - pair.dead_band))
    return select(command > pair.dead_band, min(min_duty + (1.0 - min_duty) * fraction, 1.0), 0.0)


@law
def _advance_coil_and_plunger(switch, on, charge, x, tau):
    """Return charge and opening after tau seconds with the coil on or off, and the integral of the opening (s)."""
    wait = select(on, (1.0 - charge) * switch.opening_delay, charge * switch.closing_delay)
    travels = max(tau - wait, 0.0)
    charge_after = charge + tau * select(on, 1.0 / switch.opening_delay, -1.0 / switch.closing_delay)
    travel = travels * select(on, 1.0 / switch.opening_time, 1.0 / switch.closing_time)
    y = select(on, 1.0 - x, x)
    rest, mean_rest = max(y - travel, 0.0), mean_above_zero(y, y - travel)
    after, mean = select(on, 1.0 - rest, rest), select(on, 1.0 - mean_rest, mean_rest)
    return min(max(charge_after, 0.0), 1.0), after, x * (tau - travels) + mean * travels


@law
def switch_on_and_off(switch, state, D, phase, gain, h):
    """Return the state after a step of h seconds, and the mean opening in it; `gain` is one period at most."""
    first_on = phase < D
    last = phase + gain
    edge_1, edge_2 = select(first_on, D, 1.0), select(first_on, 1.0, 1.0 + D)
    scale = h / gain
    tau_1 = scale * (min(last, edge_1) - phase)
    tau_2 = scale * max(min(last, edge_2) - edge_1, 0.0)
    tau_3 = scale * max(last - edge_2, 0.0)
    second_on = phase >= D
    c, x, open_1 = _advance_coil_and_plunger(switch, first_on, state.charge, state.opening, tau_1)
    c, x, open_2 = _advance_coil_and_plunger(switch, second_on, c, x, tau_2)
    c, x, open_3 = _advance_coil_and_plunger(switch, first_on, c, x, tau_3)
    return SwitchState(c, x), (open_1 + open_2 + open_3) * (1.0 / h)


@law
def shut(pair):  # noqa: ARG001  (signature of all valves)
    """Return the state of two closed valves."""
    return PairState(SwitchState(0.0, 0.0), SwitchState(0.0, 0.0))


@composition
def move_pair(pair, state, command, carrier, h):
    """Return the state after a step of h seconds, and the mean conductances of the paths that fill and vent hose A."""
    both, wave = join(pair, pair), join(carrier, carrier)
    duties = duty(both, join(command, -command))
    states = join(state.forward, state.back)
    moved, opened = switch_on_and_off(both.switch, states, duties, wave.phase, wave.gain, h)
    forward, back = halves(moved)
    fills, vents = halves(both.leakage + (both.conductance - both.leakage) * opened)
    return PairState(forward, back), fills, vents


@law
def pair_opening(pair, state):  # noqa: ARG001
    """Return the opening of the valve that fills hose A minus that of the other, -1..1."""
    return state.forward.opening - state.back.opening


def seized(pair: SwitchingPair) -> SwitchingPair:
    """Return the parameters of two valves whose plungers do not move, whatever the command."""
    return pair._replace(switch=pair.switch._replace(opening_time=inf, closing_time=inf))


def held_at(pair: SwitchingPair, opening: float) -> PairState:  # noqa: ARG001
    """Return the state of two valves of which one is open, by an opening of -1 to 1."""
    return PairState(SwitchState(0.0, max(opening, 0.0)), SwitchState(0.0, max(-opening, 0.0)))


KIND = ValveKind(
    name="switching",
    description=SwitchingValvesPart,
    parameters=parameters,
    parameter_types=(SwitchingPair,),
    at_rest=shut,
    move=move_pair,
    opening=pair_opening,
    start_wave=start_carrier,
    turn_wave=turn_carrier,
    seized=seized,
    held_at=held_at,
)
