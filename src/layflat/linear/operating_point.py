"""Search of the operating point of an arm whose joints are held or slide.

Friction and a valve that only leaks leave a plant many equilibria. Here the valves' mean openings are such that the
air neither gathers nor cools, and the differential pressures carry the loads: of gravity and springs for a joint that
is held; of these, friction, losses and damping for one that slides.
"""

from collections.abc import Iterator, Mapping
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.optimize import root

from layflat.arrays import Array
from layflat.description import units as u
from layflat.description.wrong import did_you_mean
from layflat.errors import InputError
from layflat.lanes import leaves, read_numbers
from layflat.linear.balance import check_balance, check_strength, hose_slopes, missing_torques, static_torque
from layflat.linear.kept_plant import measure_ripple
from layflat.linear.losses import Ripple, linearize_losses, steady_losses
from layflat.linear.point import OperatingPoint
from layflat.linear.rates import AirState, MovingJoint, PlantLaws, air_columns, linearize_rates, rates
from layflat.linear.ripple import compute_ripples, no_ripple
from layflat.linear.valve import check_response, linearize_valve, mean_paths, settle_valve
from layflat.machine import Machine, parameters
from layflat.motion.scenario import Scenario
from layflat.motion.signal_values import Angles, Pair, SignalKind, Value, check_names, read_number, read_row
from layflat.physics.joint import has_second, pressures_at_rest
from layflat.physics.line import LineParameters, NoAir
from layflat.physics.step import STEP
from layflat.sim.run import make_timing
from layflat.sim.signals import start_pressures

HELD_STATE, SLIDING_STATE = "held", "sliding"
MIN_SLIDING_SPEED = "0.3 deg/s"  # default, slow enough to stay near a configuration
RIPPLE_MARGIN = 2.0  # the default is this many times the peak of the ripple, where that is more
MIN_SPEED, MAX_SPEED = 1e-4, 1.0  # of sliding, rad/s
RIPPLE_ROUNDS = 4  # in which the ripple and the torques of losses that follow it agree
PLANT_ROUNDS = 2  # in which the ripple of the plant itself and the point agree
RATE_TOLERANCE = 1e-6  # of the scaled rates at the operating point, 1/s
FIRST_OPENINGS = np.array([0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5])  # with which a search begins
MIN_OPENED = 0.01  # difference of both paths' conductances by which a valve is open, fraction of the full one
OPENING_SCALE, TEMPERATURE_SCALE = 0.05, 10.0  # of unknowns of the search: fraction of full opening, K


def find_operating_point(
    machine: Machine,
    configuration: Angles = 0.0,
    pressures: Pair | Mapping[str, Pair] | None = None,
    joints: str | Mapping[str, str] = SLIDING_STATE,
    speed: Value | None = None,
) -> OperatingPoint:
    """Return the operating point of a machine.

    Args:
        machine: description with valve and sensors.
        configuration: angles of the joints; numbers are in rad.
        pressures: absolute pressures of hoses A and B, for all joints or by joint; numbers are in Pa; default: those
            that the valve holds while they carry the load.
        joints: "held" or "sliding", for all joints or by joint; joints that a table leaves out are held.
        speed: velocity of joints that slide; its sign is the direction; a number is in rad/s; default: 0.3 deg/s, or
            twice the velocity of the ripple where that is more.

    Raises:
        InputError: an argument is wrong, or the valve can't hold the joints there.
        KindError: a law of the machine can't be linearized.
    """
    names = list(machine.joints)
    angles = read_row(configuration, SignalKind("configuration", u.ANGLE, names), np.zeros(len(names)))
    for name, angle in zip(names, angles.tolist(), strict=True):
        parameters.check_inside_stroke(machine, name, angle, "configuration")
    arm, laws, around = parameters.plant(machine)
    timing = make_timing(machine.cycle, STEP, 1, machine)
    held = tuple(state == HELD_STATE for state in read_states(joints, names))
    plant = PlantLaws(arm, laws, around, held, machine.cycle / timing.steps)
    pairs = _pressures_in_range(pressures, machine, around)
    search = _PointSearch(machine, plant, angles, pairs, read_speed(MIN_SLIDING_SPEED if speed is None else speed))
    check_strength(names, plant, angles, search.velocities)
    x = search.solve(*search.guesses())
    if not all(held):
        # The waves' ripple depends on the point, and the losses on the ripple, little as both are.
        peaks = search.follow_ripples(x)
        if speed is None and RIPPLE_MARGIN * peaks.max() > abs(search.speed):
            search.speed = float(RIPPLE_MARGIN * peaks.max())
            peaks = search.follow_ripples(search.solve(x))
        if (peaks >= abs(search.speed)).any():
            what = f"the ripple of the valves' waves reverses joint {names[int(peaks.argmax())]!r} at {speed!r}"
            raise InputError(what, where="speed", right=f"give more than {np.degrees(peaks.max()):.3g} deg/s")
    if not all(held) or any(isinstance(joint.hose_a.line, LineParameters) for joint in laws):
        for _ in range(PLANT_ROUNDS):
            search.follow_plant(x)
            x = search.solve(x)
    return search.point(x)


def read_states(joints: object, names: list[str]) -> list[str]:
    """Return "held" or "sliding" by joint; raise InputError for other words, or joints that are not there."""
    if isinstance(joints, Mapping):
        check_names(joints, SignalKind("joints", None, names))
    states: list[Any] = [joints.get(name, HELD_STATE) if isinstance(joints, Mapping) else joints for name in names]
    for state in states:
        if state not in (HELD_STATE, SLIDING_STATE):
            right = did_you_mean(state, [HELD_STATE, SLIDING_STATE], 'give "held" or "sliding", or a table by joint')
            raise InputError(f"{state!r} is no state of a joint", where="joints", right=right)
    return states


def read_speed(speed: object) -> float:
    """Return the speed of sliding, rad/s; raise InputError unless it is plausible."""
    value = read_number(speed, u.ANGULAR_SPEED, "speed")
    if not MIN_SPEED <= abs(value) <= MAX_SPEED:
        right = 'give up to 57 deg/s forward or back, such as "2 deg/s"'
        raise InputError(f"{speed!r} is no speed to slide at", where="speed", right=right)
    return value


def _pressures_in_range(pressures: Any, machine: Machine, around: Any) -> Array:
    """Return given pressures, (joints, 2), Pa, NaN where none are given; raise InputError beyond ambient and supply."""
    pairs = start_pressures(Scenario(pressures=pressures), machine)
    lower, upper = around.ambient_pressure, around.supply_pressure
    outside = pairs[(pairs < lower) | (pairs > upper)]
    if outside.size:
        what = f"{outside[0] / 1e5:.4g} bar is beyond the pressures of the air around and of the supply"
        right = f"give absolute pressures of {lower / 1e5:.4g} to {upper / 1e5:.4g} bar"
        raise InputError(what, where="pressures", right=right)
    return pairs


class _PointSearch:
    """Search of an operating point: unknowns are, by joint, the opening and the numbers of the air."""

    def __init__(self, machine: Machine, plant: PlantLaws, angles: Array, pairs: Array, speed: float) -> None:
        self.machine, self.plant, self.angles, self.pairs = machine, plant, angles, pairs
        self.speed = speed
        around = plant.around
        _, self.pulls = parameters.mass_and_pull(plant.arm, around.payload, angles)
        self.columns = [[i for hose in air_columns(joint) for i in hose] for joint in plant.joints]
        self.hoses = [1 + int(has_second(joint.second)) for joint in plant.joints]
        self.valves = [cache(partial(mean_paths, joint.valve, h=plant.h)) for joint in plant.joints]
        self.ends: Array | None = None  # see `MeasuredRipple`
        self.added: Array | float = 0.0  # mean rates by the ripple, (joints, numbers of a `MovingJoint`)
        self.set_ripples([no_ripple(plant.h)] * len(plant.joints))

    @property
    def velocities(self) -> Array:
        """Velocities of the joints, rad/s, (joints,)."""
        return np.where(self.plant.held, 0.0, self.speed)

    def follow_ripples(self, x: Array) -> Array:
        """Set the ripples at unknowns; return the peaks of their velocities, rad/s, (joints,)."""
        h, states, waves = self.plant.h, self.states(x), []
        model = linearize_rates(self.plant, states, self.inputs(x))
        paths = [
            settle_valve(j.valve, float(row[0]), h)[1] for j, row in zip(self.plant.joints, self.apart(x), strict=True)
        ]
        for _ in range(RIPPLE_ROUNDS):
            waves = [np.column_stack([wave, self._loads(j, states[j], len(wave))]) for j, wave in enumerate(paths)]
            self.set_ripples(compute_ripples(model, waves, h))
        return np.array([np.abs(a.velocity).max() for a, _ in self.ripples])

    def follow_plant(self, x: Array) -> None:
        """Set the ripples to those of the simulated plant at unknowns, and the rates that they add to its means."""
        point = self.point(x)
        measured = measure_ripple(point)
        means = zip(point.states, measured.means.tolist(), strict=True)
        states = tuple(read_numbers(state, [state.angle, *row[1:]]) for state, row in means)
        self.added = measured.rates + point.drift - rates(self.plant, states, point.inputs)
        self.added[:, 0] = 0.0
        self.ends = measured.ends
        self.set_ripples(measured.ripples)

    def set_ripples(self, ripples: list[tuple[Ripple, Ripple]]) -> None:
        """Set the ripples at which losses are computed, of hoses A and B of each joint."""
        self.ripples = ripples
        self.losses = [cache(partial(self._loss_torque, j)) for j in range(len(ripples))]

    def sliding_hoses(self, j: int, p_a: float, p_b: float) -> Iterator[tuple[Any, float, float, Ripple]]:
        """Yield the arguments of `steady_losses` of a joint's hoses, if it slides.

        Args:
            j: number of the joint.
            p_a: absolute pressure in hose A, Pa.
            p_b: absolute pressure in hose B, Pa.
        """
        joint, ambient = self.plant.joints[j], self.plant.around.ambient_pressure
        hoses = zip((joint.hose_a, joint.hose_b)[: self.hoses[j]], (p_a, p_b), self.ripples[j], strict=False)
        for hose, p, ripple in hoses if self.velocities[j] else ():
            yield hose.loss, p - ambient, float(self.velocities[j]), ripple

    def _loads(self, j: int, state: MovingJoint, steps: int) -> Array:
        """Return the torques of a joint's losses, as a load, in the steps of a period, N m, (steps,)."""
        hoses = self.sliding_hoses(j, state.air_a.pressure, state.air_b.pressure)
        return -sum((np.resize(steady_losses(*hose)[1], steps) for hose in hoses), np.zeros(steps))

    def _loss_torque(self, j: int, p_a: float, p_b: float) -> float:
        return sum(float(steady_losses(*hose)[1].mean()) for hose in self.sliding_hoses(j, p_a, p_b))

    def solve(self, *guesses: Array) -> Array:
        """Return the unknowns at the operating point, from the first guess that leads there.

        Raises:
            InputError: none does.
        """
        for guess in guesses:
            scales = self._scales(guess)

            def residuals(x: Array, scales: Array = scales) -> Array:
                return self._residuals(x * scales)

            try:
                x = np.asarray(root(residuals, guess / scales, tol=1e-10).x) * scales
                opening = max(abs(float(numbers[0])) for numbers in self.apart(x))
                if (np.abs(self._residuals(x)) < RATE_TOLERANCE).all() and opening <= 1.0:
                    return x
            except (ValueError, ArithmeticError):  # the search has left the states that exist
                continue
        raise InputError(
            "no opening of the valves holds the joints there, or lets them slide at that speed",
            where="configuration",
            right="choose another, a smaller payload, a lower speed, or pressures to linearize at",
        )

    def point(self, x: Array) -> OperatingPoint:
        """Return the operating point of the unknowns."""
        states, inputs = self.states(x), self.inputs(x)
        change = rates(self.plant, states, inputs) + self.added
        missing = missing_torques(self.plant, states, change[:, 1])
        check_balance(list(self.machine.joints), self.plant, states, missing)
        loads = np.where(self.plant.held, 0.0, missing)
        inputs[:, 2] += loads
        openings = [float(numbers[0]) for numbers in self.apart(x)]
        pairs = zip(self.plant.joints, openings, strict=True)
        valves = tuple(linearize_valve(joint.valve, opening, self.plant.h) for joint, opening in pairs)
        for name, valve in zip(self.machine.joints, valves, strict=True):
            check_response(name, valve)
        drift = np.zeros_like(change)
        ends = np.zeros((1, *change.shape)) if self.ends is None else self.ends
        for j, columns in enumerate(self.columns):
            drift[j, columns] = change[j, columns]
        losses = tuple(
            tuple(linearize_losses(*hose) for hose in self.sliding_hoses(j, s.air_a.pressure, s.air_b.pressure))
            for j, s in enumerate(states)
        )
        return OperatingPoint(self.machine, self.plant, states, ends, inputs, valves, losses, loads, drift)

    def guesses(self) -> list[Array]:
        """Return unknowns to begin with, for a slow motion and for faster ones."""
        first = np.array([self._first_opening(j) for j in range(len(self.hoses))])
        faster = [np.sign(first) * np.maximum(np.abs(first), u) for u in FIRST_OPENINGS if u > np.abs(first).max()]
        return [self._guess(openings) for openings in ([first, *faster] if first.any() else [first])]

    def _guess(self, openings: Array) -> Array:
        """Return unknowns with these openings: pressures that are given or carry the load, ambient temperature."""
        T, parts = self.plant.around.ambient_temperature, []
        rows = zip(self.plant.joints, self.angles, self.pulls, self.pairs, self.hoses, openings, strict=True)
        for joint, q, pull, pair, count, opening in rows:
            p = np.where(np.isnan(pair), pressures_at_rest(joint, float(q), float(pull), self.plant.around), pair)
            spots = 1 + isinstance(joint.hose_a.line, LineParameters)
            parts += [opening, *[number for value in p[:count].tolist() for number in (value, T) * spots]]
        return np.array(parts)

    def _first_opening(self, j: int) -> float:
        """Return the smallest of some openings at which a joint's valve leads air to where its motion needs it."""
        leaks, direction = np.array(self.valves[j](0.0)), np.sign(self.velocities[j])
        openings = (0.0, *(direction * FIRST_OPENINGS)) if direction else (0.0,)
        least = MIN_OPENED * self.plant.joints[j].valve.conductance
        opened = (u for u in openings[1:] if direction * np.diff(leaks - self.valves[j](float(u)))[0] > least)
        return float(next(opened, 0.0))

    def _scales(self, guess: Array) -> Array:
        p_s = self.plant.around.supply_pressure
        scales = np.where(guess > 1e4, 0.1 * p_s, np.where(guess > 1.0, TEMPERATURE_SCALE, OPENING_SCALE))
        return np.asarray(scales)

    def apart(self, x: Array) -> list[Array]:
        """Return the unknowns of each joint: opening, and numbers of the air."""
        return np.split(x, np.cumsum([1 + len(columns) for columns in self.columns])[:-1])

    def states(self, x: Array) -> tuple[MovingJoint, ...]:
        """Return motion and air of the joints; a missing hose B has ambient air."""
        around, states = self.plant.around, []
        parts = zip(self.plant.joints, self.apart(x), self.angles, self.velocities, self.columns, strict=True)
        for joint, numbers, q, v, columns in parts:
            line: Any = (0.0, 0.0) if isinstance(joint.hose_a.line, LineParameters) else NoAir()
            like = MovingJoint(0.0, 0.0, AirState(0.0, 0.0, line), AirState(0.0, 0.0, line))
            row = np.resize([around.ambient_pressure, around.ambient_temperature], len(list(leaves(like))))
            row[:2], row[columns] = (q, v), numbers[1:]
            states.append(read_numbers(like, row.tolist()))
        return tuple(states)

    def inputs(self, x: Array) -> Array:
        """Return the numbers of `AirInputs`, (joints, 3): the losses are a part of the load."""
        rows = []
        for j, (numbers, state) in enumerate(zip(self.apart(x), self.states(x), strict=True)):
            opening = min(max(float(numbers[0]), -1.0), 1.0)
            loss = self.losses[j](state.air_a.pressure, state.air_b.pressure)
            rows.append([*self.valves[j](opening), -loss])
        return np.array(rows)

    def _residuals(self, x: Array) -> Array:
        """Return rates of pressures and temperatures (scaled, 1/s), and by joint what sets its opening, (unknowns,)."""
        states = self.states(x)
        change = rates(self.plant, states, self.inputs(x)) + self.added
        p_s, residuals = self.plant.around.supply_pressure, []
        for j, (row, columns, state) in enumerate(zip(change, self.columns, states, strict=True)):
            numbers = np.array(list(leaves(state)))
            air, pair = row[columns] / numbers[columns], self.pairs[j]
            p = np.array([state.air_a.pressure, state.air_b.pressure])
            hoses = [0, len(columns) // 2][: self.hoses[j]]
            balance = row[1]
            if self.plant.held[j]:
                joint = self.plant.joints[j]
                torque = static_torque(joint, state, self.pulls[j], self.plant.around.ambient_pressure)
                balance = torque / (p_s * np.abs(hose_slopes(joint, state.angle)).sum())
            if not np.isnan(pair).any():
                balance = air[hoses[0]] - (air[hoses[1]] if len(hoses) > 1 else 0.0)
                air[hoses] = (p - pair)[: len(hoses)] / p_s
            residuals += [balance, *air]
        return np.array(residuals)
