"""Joints that are advanced step by step from outside, with faults: kinked tubes, burst hoses, seized valves."""

from abc import ABC, abstractmethod
from math import exp
from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.jit import law
from layflat.lanes import read_numbers, write_numbers
from layflat.physics.adjustable import FULL_FRACTIONS
from layflat.physics.chamber import air_mass, energy, pressure, temperature
from layflat.physics.joint import HoseState, JointParameters, Surroundings
from layflat.physics.valves import held_at, seized

BURST_TIME = 0.02  # time constant with which a burst hose loses its air, s


def kink_valve(valve: Any, fraction: float) -> Any:
    """Return the parameters of a valve whose conductances a kink reduces to a fraction (0 to 1)."""
    return valve._replace(conductance=fraction * valve.conductance, leakage=fraction * valve.leakage)


@law
def leak_through_hole(hose, state, fraction, p_a):
    """Return the state of a hose that has lost a fraction of its gauge pressure (ambient p_a, Pa), isothermally."""
    V = state.volume
    p = pressure(hose.chamber, state.energy, V, p_a)
    T = temperature(hose.chamber, p, state.mass, V, p_a)
    p = p - fraction * (p - p_a)
    return HoseState(
        energy(hose.chamber, p, V, p_a),
        air_mass(hose.chamber, p, T, V, p_a),
        V,
        p,
        state.pressure_change,
        state.mass_change,
        state.loss,
        state.line,
    )


class DrivenInputs(NamedTuple):
    """Input signals of a joint."""

    voltage: float  # to the valve's driver, V
    load: float  # external torque, N m
    hole_a: float  # fraction of its gauge pressure that hose A loses through a hole in a step; 0: no hole
    hole_b: float  # likewise of hose B
    brake: float  # commanded fraction of the brake's maximum torque, 0..1
    dither: float  # commanded fraction of the valve's dither, 0..1
    supply: float  # commanded fraction of the supply's gauge pressure, 0..1


class DrivenOutputs(NamedTuple):
    """Output signals of a joint: angle (rad), velocity (rad/s), absolute pressures (Pa)."""

    angle: float  # rad
    velocity: float  # rad/s
    pressure_a: float  # absolute, Pa
    pressure_b: float  # absolute, Pa


def field_columns(cls: Any) -> Any:
    """Return a named tuple of a class whose fields are their own column indices in a row of numbers."""
    return cls(*range(len(cls._fields)))


INPUT_COLUMNS, OUTPUT_COLUMNS, SURROUNDINGS_COLUMNS = (
    field_columns(DrivenInputs),
    field_columns(DrivenOutputs),
    field_columns(Surroundings),
)


class DrivenJoints(ABC):
    """Base of joints that are advanced from outside; subclasses keep rows of numbers of tuples like `_like` in `_kept`.

    Args:
        joints: parameters of the joints.
        around: numbers of `Surroundings`, changed in place.
        h: time step, s: the fraction of air that a burst hose loses in it follows from `BURST_TIME`.

    Attributes:
        load: external torque on each joint, N m, (joints,); items can be set.
    """

    _state_array: Array
    _like: Any

    def __init__(self, joints: tuple[JointParameters, ...], around: Array, h: float) -> None:
        """Set inputs without load and faults, with centred valves."""
        n = len(joints)
        self._healthy, self._around, self._lost = joints, around, 1.0 - exp(-h / BURST_TIME)
        self._given, self._seen = np.zeros((n, len(DrivenInputs._fields))), np.zeros((n, len(DrivenOutputs._fields)))
        self._voltages, self.load = self._given[:, INPUT_COLUMNS.voltage], self._given[:, INPUT_COLUMNS.load]
        self._holes = self._given[:, INPUT_COLUMNS.hole_a : INPUT_COLUMNS.brake]
        self._fractions = self._given[:, INPUT_COLUMNS.brake :]
        self._fractions[:] = FULL_FRACTIONS
        self._voltages[:] = [joint.valve.centre_voltage for joint in joints]
        self._seized: dict[int, float] = {}
        self._shares = np.ones(n)

    @property
    def supply(self) -> float:
        """Absolute pressure at the valves, Pa; settable."""
        return float(self._around[SURROUNDINGS_COLUMNS.supply_pressure])

    @supply.setter
    def supply(self, pressure: float) -> None:
        self._around[SURROUNDINGS_COLUMNS.supply_pressure] = pressure

    @property
    def angles(self) -> Array:
        """Angles of the joints, rad, (joints,)."""
        return self._seen[:, OUTPUT_COLUMNS.angle].copy()

    @property
    def velocities(self) -> Array:
        """Velocities of the joints, rad/s, (joints,)."""
        return self._seen[:, OUTPUT_COLUMNS.velocity].copy()

    @property
    def pressures(self) -> Array:
        """Absolute pressures in hoses A and B, Pa, (joints, 2)."""
        return self._seen[:, OUTPUT_COLUMNS.pressure_a :].copy()

    def seize(self, joint: int, opening: float | None) -> None:
        """Seize a joint's valve at an opening (-1 to 1) whatever the command; None releases it.

        Raises:
            KindError: the kind of the valve can't be seized.
        """
        self._seized.pop(joint, None)
        if opening is not None:
            self._seized[joint] = opening
            kept = read_numbers(self._like, self._state_array[joint])
            valve = held_at(self._healthy[joint].valve, opening)
            write_numbers(self._state_array[joint], kept._replace(state=kept.state._replace(valve=valve)))
        self._write_joints()

    def kink(self, joint: int, share: float) -> None:
        """Reduce the conductances of a joint's valve to a fraction `share` of the healthy ones; 1 removes the kink."""
        self._shares[joint] = share
        self._write_joints()

    def burst(self, joint: int, hose: int | None) -> None:
        """Burst a hose of a joint (0: A, 1: B), which loses its air through a hole; repair the other, for None both."""
        self._holes[joint] = 0.0
        if hose is not None:
            self._holes[joint, hose] = self._lost

    def _joints_now(self) -> tuple[JointParameters, ...]:
        """Return the parameters of the joints, with those valves seized or kinked that have these faults."""
        valves = [seized(joint.valve) if j in self._seized else joint.valve for j, joint in enumerate(self._healthy)]
        shares = self._shares.tolist()
        return tuple(
            joint._replace(valve=kink_valve(valve, share))
            for joint, valve, share in zip(self._healthy, valves, shares, strict=True)
        )

    @abstractmethod
    def _write_joints(self) -> None:
        """Hand changed parameters to the compiled laws."""


class MachinePlant(DrivenJoints):
    """Plant of a machine that is advanced in time from outside, such as the one behind a virtual rig."""

    joints: tuple[str, ...]  # names, from base to tip
    payload: float  # kg; settable

    @property
    @abstractmethod
    def time(self) -> float:
        """Time to which it has been advanced, s."""

    @abstractmethod
    def drive(self, voltages: Array) -> None:
        """Set the voltages of the valves' drivers (V, (joints,)), which hold until the next call."""

    @abstractmethod
    def advance(self, until: float) -> None:
        """Advance to the last whole step up to `until` (s); raise DivergedError if the machine diverged."""

    @abstractmethod
    def sense(self) -> tuple[Array, Array]:
        """Return angles (rad) and differential pressures (Pa) as the converters report them, with noise, (joints,)."""

    @abstractmethod
    def grip(self, joint: int, torque: float) -> None:
        """Set the torque (N m) that is added to the one at which a joint's brake slips; 0 leaves the brake's own."""
