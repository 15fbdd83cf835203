"""Rates of change of a plant's air and motion, from its own laws: a step of the plant as the step goes to zero.

| symbol | meaning | unit |
|---|---|---|
| q, v | joint angle and velocity | rad, rad/s |
| p, T | absolute pressure and temperature of the air in a hose, or at the valve's end of its tube | Pa, K |
| h | step | s |

A law is written once: no second, continuous form of the balances of air, energy and momentum stands here. A step of h
from a state, less the state, over h is its rate, with an error in proportion to h; twice the rate of half a step less
that of a whole one has an error of h squared. The valve's laws and those of the losses have memories of their own and
are linearized apart (valve.py, losses.py): here the conductances of the valve's paths, and the torque of the losses as
part of the load, are inputs. Each path is an on/off valve that is seized at an opening.
"""

from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.lanes import leaves, mapped, read_numbers
from layflat.linear.differences import jacobian
from layflat.linear.valve import PathConductances
from layflat.physics.air import CV, GAMMA
from layflat.physics.chamber import air_mass, energy, pressure, temperature
from layflat.physics.hose import swept_volume
from layflat.physics.hysteresis import at_rest
from layflat.physics.joint import (
    AirLedger,
    Drive,
    HoseParameters,
    HoseState,
    JointMotion,
    JointParameters,
    JointState,
    Surroundings,
    has_second,
)
from layflat.physics.line import LineAir, LineParameters, NoAir, line_air
from layflat.physics.plant import advance_arm, pack_joints
from layflat.physics.valves.switching import PairState, Switch, SwitchingPair, SwitchState, seized, start_carrier

RATE_STEP = 1e-6  # h, s: far below the time constants of air and arm, far above rounding
CLAMP_TORQUE = 1e9  # friction that nothing overcomes, N m
ANGLE_CHANGE, VELOCITY_CHANGE = 1e-5, 0.05  # for derivatives: rad, and fraction of the velocity
RELATIVE_CHANGE, LOAD_CHANGE = 1e-4, 0.1  # of pressures, temperatures and conductances, and N m


class AirState(NamedTuple):
    """State of the air of a hose and of the tube before it (NoAir without one)."""

    pressure: float  # p, Pa
    temperature: float  # T, K
    line: Any


class MovingJoint(NamedTuple):
    """State of a joint: motion and air."""

    angle: float  # q, rad
    velocity: float  # v, rad/s
    air_a: AirState
    air_b: AirState


class AirInputs(NamedTuple):
    """Inputs of a joint's air and motion."""

    fills: float  # conductance of the path that fills hose A and vents hose B, m3/(s Pa)
    vents: float  # of the reverse, m3/(s Pa)
    load: float  # torque on the joint, N m


class PlantLaws(NamedTuple):
    """Parameters of a plant whose joints are held or slide."""

    arm: Any
    joints: tuple[JointParameters, ...]
    around: Surroundings
    held: tuple[bool, ...]
    h: float  # step of the simulated plant, s


def hose_state(hose: HoseParameters, air: AirState, travel: float, loss: Any, p_a: float) -> HoseState:
    """Return the state of a hose with its air.

    Args:
        hose: parameters.
        air: state of the air.
        travel: of the hose, rad.
        loss: state of its losses.
        p_a: ambient pressure, Pa.
    """
    volume = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    p, T = air.pressure, air.temperature
    mass = air_mass(hose.chamber, p, T, volume, p_a)
    line = air.line if isinstance(air.line, NoAir) else line_air(hose.line, *air.line)
    return HoseState(energy(hose.chamber, p, volume, p_a), mass, volume, p, 0.0, 0.0, loss, line)


def joint_state(joint: JointParameters, moving: MovingJoint, valve: Any, losses: Any, p_a: float) -> JointState:
    """Return the state of a joint for the plant's laws, from motion and air.

    Args:
        joint: parameters.
        moving: motion and air.
        valve: state of the valve.
        losses: states of the losses of hoses A and B.
        p_a: ambient pressure, Pa.
    """
    travel_a, travel_b = joint.hose_a.neutral + moving.angle, joint.hose_b.neutral - moving.angle
    a = hose_state(joint.hose_a, moving.air_a, travel_a, losses[0], p_a)
    b = hose_state(joint.hose_b, moving.air_b, travel_b, losses[1], p_a)
    return JointState(JointMotion(moving.angle, moving.velocity, 0.0), valve, a, b, AirLedger(0.0))


def set_back(joint: JointParameters, state: JointState, like: MovingJoint, change: Array, p_a: float) -> JointState:
    """Return the state of a joint less a change of its motion and air; valve and losses stay.

    Args:
        joint: parameters.
        state: present state.
        like: any state of its motion and air.
        change: of the numbers of a `MovingJoint`, in SI units.
        p_a: ambient pressure, Pa.
    """
    before, old = read_joint(joint, state, like, p_a), (state.hose_a, state.hose_b)
    moving = read_numbers(like, (np.array(list(leaves(before))) - change).tolist())
    after = joint_state(joint, moving, state.valve, [hose.loss for hose in old], p_a)
    # The plant extrapolates from its last step.
    shifts = moving.air_a.pressure - before.air_a.pressure, moving.air_b.pressure - before.air_b.pressure
    a, b = (
        new._replace(pressure=last.pressure + shift, pressure_change=last.pressure_change, mass_change=last.mass_change)
        for new, last, shift in zip((after.hose_a, after.hose_b), old, shifts, strict=True)
    )
    motion = after.motion._replace(velocity_change=state.motion.velocity_change)
    return after._replace(motion=motion, hose_a=a, hose_b=b, ledger=state.ledger)


def rates(plant: PlantLaws, states: tuple[MovingJoint, ...], inputs: Array) -> Array:
    """Return the rates of change of all numbers of the joints' states, (joints, numbers), in SI units per second.

    Args:
        plant: the plant; held joints do not move.
        states: state of each joint.
        inputs: numbers of `AirInputs`, (joints, 3).
    """
    before = np.array([list(leaves(state)) for state in states])
    whole, half = ((_numbers_after(plant, states, inputs, h) - before) / h for h in (RATE_STEP, 0.5 * RATE_STEP))
    return 2.0 * half - whole  # type: ignore[no-any-return]


class LinearRates(NamedTuple):
    """Small-signal model of air and motion: dx/dt = A x + B u."""

    A: Array  # (states, states)
    B: Array  # (states, 3 * joints)
    places: list[tuple[int, int]]  # joint of each state, and its column among the numbers of a `MovingJoint`


def linearize_rates(plant: PlantLaws, states: tuple[MovingJoint, ...], inputs: Array) -> LinearRates:
    """Return the derivatives of the rates of all states that can change.

    Args:
        plant: the plant.
        states: state of each joint.
        inputs: numbers of `AirInputs`, (joints, 3).
    """
    rows = np.array([list(leaves(state)) for state in states])
    n, count = rows.shape

    def change(numbers: Array) -> Array:
        parts = numbers[: n * count].reshape(n, count).tolist()
        moved = tuple(read_numbers(like, part) for like, part in zip(states, parts, strict=True))
        return rates(plant, moved, numbers[n * count :].reshape(n, 3))

    changes = RELATIVE_CHANGE * np.abs(rows)
    changes[:, 0], changes[:, 1] = ANGLE_CHANGE, VELOCITY_CHANGE * max(np.abs(rows[:, 1]).max(), ANGLE_CHANGE)
    conductances = [RELATIVE_CHANGE * joint.valve.conductance for joint in plant.joints]
    input_changes = np.array([[c, c, LOAD_CHANGE] for c in conductances])
    point = np.concatenate([rows.ravel(), inputs.ravel()])
    every = jacobian(change, point, [*changes.ravel(), *input_changes.ravel()])
    places = []
    for j, joint in enumerate(plant.joints):
        hoses = air_columns(joint)
        places += [(j, i) for i in (*(() if plant.held[j] else (0, 1)), *hoses[0], *hoses[1])]
    kept = [count * j + i for j, i in places]
    return LinearRates(every[np.ix_(kept, kept)], every[kept, n * count :], places)


def air_columns(joint: JointParameters) -> tuple[list[int], list[int]]:
    """Return the columns of the numbers of a `MovingJoint` that are air in hose A, and in hose B; none if missing."""
    count = 2 + (2 if isinstance(joint.hose_a.line, LineParameters) else 0)
    columns_b = list(range(2 + count, 2 + 2 * count)) if has_second(joint.second) else []
    return list(range(2, 2 + count)), columns_b


def _numbers_after(plant: PlantLaws, states: tuple[MovingJoint, ...], inputs: Array, h: float) -> Array:
    """Return the numbers of the states after a step of h seconds, interpreted by Python."""
    p_a, parts = plant.around.ambient_pressure, []
    for joint, state, given, is_held in zip(plant.joints, states, inputs.tolist(), plant.held, strict=True):
        fills, vents, load = given
        open_joint, valve = _open_paths(joint, PathConductances(fills, vents))
        losses = at_rest(open_joint.hose_a.loss), at_rest(open_joint.hose_b.loss)
        bare = joint_state(open_joint, state, valve, losses, p_a)
        drive = Drive(0.0, CLAMP_TORQUE if is_held else joint.brake_torque, load, plant.around.supply_pressure)
        parts.append((open_joint, bare, drive, start_carrier(open_joint.valve, 0.0, h)))
    joints, after, drives, waves = map(list, zip(*parts, strict=True))
    packed = pack_joints.py_func(plant.arm, joints)
    advance_arm.py_func(plant.arm, packed, after, drives, waves, plant.around, h, 1)
    ended = zip(joints, after, states, strict=True)
    return np.array([list(leaves(read_joint(joint, state, like, p_a))) for joint, state, like in ended])


def _open_paths(joint: JointParameters, paths: PathConductances) -> tuple[JointParameters, PairState]:
    """Return the parameters of a joint whose paths have constant conductances and that has no losses, and its valve."""
    full, valve = max(*paths, joint.valve.conductance), joint.valve
    switch, flow = Switch(1.0, 1.0, 1.0, 1.0), (full, 0.0, valve.critical_ratio, valve.laminar_slope)
    pair = seized(SwitchingPair(switch, *flow, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0))
    without = [hose._replace(loss=mapped(hose.loss, lambda _: 0.0)) for hose in (joint.hose_a, joint.hose_b)]
    state = PairState(SwitchState(0.0, paths.fills / full), SwitchState(0.0, paths.vents / full))
    return joint._replace(valve=pair, hose_a=without[0], hose_b=without[1]), state


def read_joint(joint: JointParameters, state: JointState, like: MovingJoint, p_a: float) -> MovingJoint:
    """Return motion and air of a joint from its state.

    Args:
        joint: parameters.
        state: its state.
        like: any state of its motion and air.
        p_a: ambient pressure, Pa.
    """
    hoses = zip((joint.hose_a, joint.hose_b), (state.hose_a, state.hose_b), (like.air_a, like.air_b), strict=True)
    a, b = (_read_air(hose, hose_now, air, p_a) for hose, hose_now, air in hoses)
    return MovingJoint(state.motion.angle, state.motion.velocity, a, b)


def _read_air(hose: HoseParameters, state: HoseState, like: AirState, p_a: float) -> AirState:
    """Return the air of a hose from its energy and mass."""
    p = pressure(hose.chamber, state.energy, state.volume, p_a)
    T = temperature(hose.chamber, p, state.mass, state.volume, p_a)
    line = state.line
    if isinstance(line, LineAir):
        line = read_numbers(like.line, [(GAMMA - 1.0) * line.energy / hose.line.volume, line.energy / (CV * line.mass)])
    return AirState(p, T, line)
