"""Joints that others move on bit by bit: numbers in arrays with a row a joint, and kinks, holes and stuck valves."""

from abc import ABC, abstractmethod
from math import exp
from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.jit import law
from layflat.lanes import read_numbers, write_numbers
from layflat.physics.chamber import air_mass, energy, pressure, temperature
from layflat.physics.joint import HoseState, Joint, Surroundings
from layflat.physics.valves import held_at, seized

BURST_TIME = 0.02  # time constant with which a burst hose loses its air, s


def kinked(valve: Any, share: float) -> Any:
    """A valve behind a kink that lets through a share of what the valve does."""
    return valve._replace(conductance=share * valve.conductance, leakage=share * valve.leakage)


@law
def through_hole(hose, state, share, p_a):
    """State of a hose that has lost a share of its pressure above the outside (p_a, Pa), as warm as before."""
    V = state.volume
    p = pressure(hose.chamber, state.energy, V, p_a)
    T = temperature(hose.chamber, p, state.mass, V, p_a)
    p = p - share * (p - p_a)
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


class Inputs(NamedTuple):
    """Signals that act on a joint from outside."""

    voltage: float
    load: float  # N m
    hole_a: float  # share of its pressure above the outside that hose A loses through a hole in a step; 0: it has none
    hole_b: float


class Outputs(NamedTuple):
    """State of a joint: angle (rad), velocity (rad/s), absolute pressures (Pa)."""

    angle: float
    velocity: float
    pressure_a: float
    pressure_b: float


def columns(kind: Any) -> Any:
    """Return where each number of a named tuple stands in a row of them."""
    return kind(*range(len(kind._fields)))


GIVEN, SEEN, AIR = columns(Inputs), columns(Outputs), columns(Surroundings)


class DrivenJoints(ABC):
    """Base of all such joints; who moves them on keeps rows of numbers in `_kept`, as tuples like `_like`.

    Args:
        joints: their parameters.
        around: numbers of `Surroundings`, changed in place.
        h: step in which a burst hose loses its share of air, s.

    Attributes:
        load: torque from outside on each joint, N m, (joints,); items can be set.
    """

    _kept: Array
    _like: Any

    def __init__(self, joints: tuple[Joint, ...], around: Array, h: float) -> None:
        n = len(joints)
        self._healthy, self._around, self._lost = joints, around, 1.0 - exp(-h / BURST_TIME)
        self._given, self._seen = np.zeros((n, len(Inputs._fields))), np.zeros((n, len(Outputs._fields)))
        self._voltages, self.load = self._given[:, GIVEN.voltage], self._given[:, GIVEN.load]
        self._holes = self._given[:, GIVEN.hole_a :]
        self._voltages[:] = [joint.valve.centre_voltage for joint in joints]
        self._seized: dict[int, float] = {}
        self._shares = np.ones(n)

    @property
    def supply(self) -> float:
        """Absolute pressure at the valves, Pa; settable."""
        return float(self._around[AIR.supply_pressure])

    @supply.setter
    def supply(self, pressure: float) -> None:
        self._around[AIR.supply_pressure] = pressure

    @property
    def angles(self) -> Array:
        """Angles of the joints, rad, (joints,)."""
        return self._seen[:, SEEN.angle].copy()

    @property
    def velocities(self) -> Array:
        """Velocities of the joints, rad/s, (joints,)."""
        return self._seen[:, SEEN.velocity].copy()

    @property
    def pressures(self) -> Array:
        """Absolute pressures in hoses A and B, Pa, (joints, 2)."""
        return self._seen[:, SEEN.pressure_a :].copy()

    def seize(self, joint: int, opening: float | None) -> None:
        """Hold a joint's valve at an opening (-1 to 1) whatever is asked; None lets it go."""
        self._seized.pop(joint, None)
        if opening is not None:
            self._seized[joint] = opening
            kept = read_numbers(self._like, self._kept[joint])
            valve = held_at(self._healthy[joint].valve, opening)
            write_numbers(self._kept[joint], kept._replace(state=kept.state._replace(valve=valve)))
        self._write_joints()

    def kink(self, joint: int, share: float) -> None:
        """Narrow what a joint's valve lets through to a share of what it was; 1 mends it."""
        self._shares[joint] = share
        self._write_joints()

    def burst(self, joint: int, hose: int | None) -> None:
        """Burst a hose of a joint (0: A, 1: B), which loses its air through a hole; None mends both."""
        self._holes[joint] = 0.0
        if hose is not None:
            self._holes[joint, hose] = self._lost

    def _joints_now(self) -> tuple[Joint, ...]:
        """Parameters of the joints, with valves that stick or are kinked."""
        valves = [seized(joint.valve) if j in self._seized else joint.valve for j, joint in enumerate(self._healthy)]
        shares = self._shares.tolist()
        return tuple(
            joint._replace(valve=kinked(valve, share))
            for joint, valve, share in zip(self._healthy, valves, shares, strict=True)
        )

    @abstractmethod
    def _write_joints(self) -> None:
        """Tell the compiled laws that parameters have changed."""


class Plant(DrivenJoints):
    """A machine through time, a bit at a time: what a virtual rig can have behind it."""

    joints: tuple[str, ...]  # names, from base to tip
    payload: float  # kg; settable

    @property
    @abstractmethod
    def time(self) -> float:
        """Time to which it has been advanced, s."""

    @abstractmethod
    def drive(self, voltages: Array) -> None:
        """Give the valves' drivers voltages (V, (joints,)), which hold until the next."""

    @abstractmethod
    def advance(self, until: float) -> None:
        """Advance to the last whole step before `until` (s); raise DivergedError if the machine diverged."""

    @abstractmethod
    def sense(self) -> tuple[Array, Array]:
        """Angles (rad) and differential pressures (Pa) as the converters report them now, noise included, (joints,)."""

    @abstractmethod
    def grip(self, joint: int, torque: float) -> None:
        """Hold a joint as a brake does, by so much more than its own (N m); 0 lets it go."""
