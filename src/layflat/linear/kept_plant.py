"""Simulated plant that is kept at an operating point: set back by its rotation and by what pressures drift.

A linear model is that of one configuration and its pressures. So a plant is set back by its rotation after each control
cycle, and by what given pressures drift after each step: no load falls over, and inertia and volumes stay. So are
losses, which creep on, after each period of the valves' waves.
"""

from collections.abc import Sequence
from math import lcm
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.lanes import leaves, mapped
from layflat.linear.losses import Ripple
from layflat.linear.point import OperatingPoint
from layflat.linear.rates import joint_state, read_joint, set_back
from layflat.physics.hysteresis import at_rest
from layflat.physics.joint import JointState
from layflat.sim.plant import SteppedPlant

GRIP_TORQUE = 1e6  # torque that holds a joint, N m
MIN_DRIFT = 1.0  # of pressures that are set back, Pa/s
RIPPLE_TIME = 0.1  # in which the ripple settles, s


class KeptPlant:
    """Plant at an operating point.

    Args:
        point: the point.

    Attributes:
        point: the same.
        plant: the plant, which its caller may read.
        cycles: control cycles since the start.
        period: after which all waves begin anew, control cycles.
        first: numbers of the joints' states at the point, (joints, numbers of a `JointState`).
        is_loss: 1 for those of losses, 0 for others, likewise.
    """

    def __init__(self, point: OperatingPoint) -> None:
        self.point, self.plant = point, SteppedPlant(point.machine, noise=False)
        joints = []
        for j, (joint, state) in enumerate(zip(point.plant.joints, point.states, strict=True)):
            slid = [loss.state for loss in point.losses[j]]
            losses = [*slid, *[at_rest(hose.loss) for hose in (joint.hose_a, joint.hose_b)][len(slid) :]]
            joints.append(joint_state(joint, state, point.valves[j].state, losses, point.plant.around.ambient_pressure))
        self.plant.place(joints, [valve.opening for valve in point.valves])
        placed = self.plant.states
        self.set_back(-point.ends[-1])
        for j, held in enumerate(point.plant.held):
            self.plant.grip(j, GRIP_TORQUE if held else 0.0)
        self._drifts = bool(np.abs(point.drift).max() > MIN_DRIFT)
        self.first, self.cycles = self.numbers(placed), 0
        marked = [_with_losses(mapped(state, lambda _: 0.0), mapped(state, lambda _: 1.0)) for state in placed]
        self.is_loss = self.numbers(marked)
        self.steps = round(point.machine.cycle / point.plant.h)
        self.period = lcm(self.steps, *(len(valve.wave) for valve in point.valves)) // self.steps

    def motion(self) -> list[Array]:
        """Return angles, velocities (rad, rad/s), and absolute pressures of hoses A and B (Pa), (joints,) each."""
        return [self.plant.angles, self.plant.velocities, *self.plant.pressures.T]

    def advance(
        self, voltages: Array | float = 0.0, loads: Array | float = 0.0, seen: list[Array] | None = None
    ) -> None:
        """Advance by a control cycle.

        Args:
            voltages: added to those of the point, V, (joints,).
            loads: likewise, N m, (joints,).
            seen: list to which each step adds the numbers of `MovingJoint`, and pressures in its middle, (joints, ...).
        """
        self.plant.load[:] = self.point.loads + loads
        self.plant.drive(self.point.voltages + voltages)
        stops, shift = 1 if seen is None and not self._drifts else self.steps, np.zeros_like(self.first)
        if self._drifts:
            states, drift = self.plant.states, self.point.plant.h * self.point.drift
            shift = self.numbers(self._take_change(states, drift)) - self.numbers(states)
        for i in range(1, stops + 1):
            self.plant.advance((self.cycles + i / stops) * self.point.machine.cycle)
            if seen is not None:
                seen.append(self._read())
            if self._drifts:
                self.plant.shift(shift)
        self.cycles += 1

    def _read(self) -> Array:
        """Return the numbers of `MovingJoint` of all joints, and pressures in the middle of the step, (joints, ...)."""
        ambient, rows = self.point.plant.around.ambient_pressure, []
        for joint, state, like in zip(self.point.plant.joints, self.plant.states, self.point.states, strict=True):
            middles = [hose.pressure - 0.5 * hose.pressure_change for hose in (state.hose_a, state.hose_b)]
            rows.append([*leaves(read_joint(joint, state, like, ambient)), *middles])
        return np.array(rows)

    def numbers(self, states: Sequence[JointState] | None = None) -> Array:
        """Return the numbers of the joints' states, or of others, (joints, numbers of a `JointState`)."""
        return np.array([[*leaves(state)] for state in (self.plant.states if states is None else states)])

    def _take_change(self, states: Sequence[JointState], change: Array) -> list[JointState]:
        """Return states less a change of motion and air, (joints, numbers of a `MovingJoint`), in SI units."""
        ambient = self.point.plant.around.ambient_pressure
        rows = zip(self.point.plant.joints, states, self.point.states, change, strict=True)
        return [set_back(joint, state, like, row, ambient) for joint, state, like, row in rows]

    def set_back(self, change: Array) -> None:
        """Take a change from motion and air, (joints, numbers of a `MovingJoint`), in SI units."""
        self.plant.place(self._take_change(self.plant.states, change))


def keep_in_place(plants: Sequence[KeptPlant]) -> None:
    """Set plants back by the mean of their rotations, and where their waves begin anew, of their losses.

    Args:
        plants: that move alike, after a control cycle.
    """
    first, change = plants[0], np.zeros_like(plants[0].point.drift)
    start = [state.angle for state in first.point.states]
    change[:, 0] = np.mean([plant.plant.angles for plant in plants], axis=0) - start
    for plant in plants:
        plant.set_back(change)
    if first.cycles % first.period == 0:
        crept = first.is_loss * (np.mean([plant.numbers() for plant in plants], axis=0) - first.first)
        for plant in plants:
            plant.plant.shift(-crept)


class MeasuredRipple(NamedTuple):
    """Ripple of a plant about its means over a period of its valves' waves."""

    ripples: list[tuple[Ripple, Ripple]]  # of hoses A and B, by joint
    ends: Array  # deviations at the ends of the steps, (steps, joints, numbers of a `MovingJoint`), SI
    means: Array  # (joints, numbers), SI
    rates: Array  # of change of the means, (joints, numbers), SI


def measure_ripple(point: OperatingPoint) -> MeasuredRipple:
    """Return the ripple of the simulated plant at an operating point."""
    plant, n, h = KeptPlant(point), lcm(*(len(valve.wave) for valve in point.valves)), point.plant.h
    seen: list[Array] = []
    settling = round(RIPPLE_TIME / point.machine.cycle)
    for k in range(settling + -(-3 * n // plant.steps)):
        plant.advance(seen=seen if k >= settling else None)
        keep_in_place([plant])
    begin = -settling * plant.steps % n
    rows = np.array(seen[begin : begin + 2 * n]).reshape(2, n, len(point.states), -1)
    means = rows.mean(axis=1)
    trend = means[1] - means[0]
    ripple = rows[1] - means[1] - trend * ((np.arange(n) - 0.5 * (n - 1)) / n)[:, np.newaxis, np.newaxis]
    ripple[:, :, 0] = trend[:, 0] = 0.0  # rotations are set back
    starts = np.roll(ripple[:, :, 1], 1, axis=0)
    ripples = [
        (Ripple(h, v, p_a), Ripple(h, v, p_b))
        for v, p_a, p_b in zip(starts.T, ripple[:, :, -2].T, ripple[:, :, -1].T, strict=True)
    ]
    return MeasuredRipple(ripples, ripple[:, :, :-2], rows.mean(axis=(0, 1))[:, :-2], trend[:, :-2] / (n * h))


def _with_losses(state: JointState, other: JointState) -> JointState:
    """Return a state with the losses of another one."""
    a, b = state.hose_a._replace(loss=other.hose_a.loss), state.hose_b._replace(loss=other.hose_b.loss)
    return state._replace(hose_a=a, hose_b=b)
