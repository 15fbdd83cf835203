"""Unknowns of a machine in motion, block by block, with their bounds; those of an arm in space by link.

The torque of a joint contains of the links after it only the part that its own rotation moves. Some parameters
therefore act on no joint at all (the height of a base that turns about an upright axis), and others only together (the
mass of a link and the centre of the link before it). The first are left out here; a fit reports the others.

Pairs of elements of a joint's losses can be exchanged for others that act nearly the same. Two elements of given
weights w that slip at d have, together, a stiffness k = sum w / d and an area s = sum w d of their small and large
loops. Both stay the same where each d is replaced by s / (k d): only the remainder of the curve distinguishes the two,
and a local search ends at whichever is nearer.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from layflat.arrays import Array
from layflat.description.change import replace_value, value_at
from layflat.errors import InputError
from layflat.identify.benches import check_choices
from layflat.identify.model import (
    ParameterSpec,
    RangeRule,
    Unknown,
    factor_range,
    fixed_range,
    symmetric_range,
    zero_range,
)
from layflat.machine import Machine, parameters
from layflat.motion.path import half_strokes
from layflat.physics.arms import dynamics
from layflat.physics.arms.chain.description import LinkPart
from layflat.physics.driver import MAX_DELAY_CYCLES
from layflat.physics.friction.stribeck import StribeckPart
from layflat.physics.hysteresis.elasto_slip import ElastoSlipPart
from layflat.physics.valves.switching import SwitchingValvesPart


def mirrored_losses(machine: Machine, columns: dict[str, Array]) -> Iterator[dict[str, Array]]:
    """Yield other deflections of each pair of a joint's elasto-slip elements that act nearly as the present ones.

    Args:
        machine: machine as described; its weights are held.
        columns: values of the unknowns by path, rad for deflections.

    Yields:
        The two deflections that change, by path.
    """
    for name, joint in machine.joints.items():
        if not isinstance(joint.losses, ElastoSlipPart):
            continue
        paths = [f"joint.{name}.losses.deflections.{i}" for i in range(len(joint.losses.deflections))]
        weights = zip(paths, joint.losses.weights, strict=True)
        sought = [(path, weight) for path, weight in weights if path in columns and weight > 0.0]
        for pair in combinations(sought, 2):
            k = sum(weight / columns[path] for path, weight in pair)
            s = sum(weight * columns[path] for path, weight in pair)
            yield {path: s / (k * columns[path]) for path, _ in pair}


# Excitations: what a log has to contain.
RESTS_AND_RAMPS = "rests and slow ramps in many configurations of all joints"
JOINT_CHIRPS = "chirps up to 3 Hz of all joints, one after the other, without payload"
LINK_WEIGHING = "the weight of the link by itself"

MASS_RANGE = factor_range(3.0, 0.1, log=False)  # linear, as masses add to known ones
TEST_MOTIONS = 3  # random ones, by which a parameter that acts on no joint is recognised
CENTRE_SHIFT_RATIO = 0.1  # of a link's size, by which its centre is then moved
MIN_TORQUE_CHANGE = 1e-9  # relative change of the torques by a parameter that acts


def link_parameters(machine: Machine) -> list[ParameterSpec]:
    """Return the parameters of every link that act on a joint, from the base on; none if links belong to joints."""
    if not machine.arm.own_links:
        return []
    ends = [machine.arm.link[name].position for name in machine.arm.joints[1:]] + [machine.arm.tool]
    shifted = _shift_centres(machine)
    torques = sample_torques(shifted)
    return [
        spec._replace(path=f"arm.link.{name}.{spec.path}")
        for name, end in zip(machine.arm.joints, ends, strict=True)
        for spec in _single_link_parameters(
            machine.arm.link[name], max(float(np.linalg.norm(end)), _link_reach(machine.arm.link[name]))
        )
        if _changes_torques(shifted, f"arm.link.{name}.{spec.path}", torques)
    ]


def _single_link_parameters(link: LinkPart, length: float) -> Iterator[ParameterSpec]:
    """Yield the parameters of a chain's link (length in m) that may be identified alone."""
    yield ParameterSpec("mass", "kg", MASS_RANGE, LINK_WEIGHING)
    for i in range(3):
        yield ParameterSpec(f"centre.{i}", "m", symmetric_range(lambda _: 0.5 * length), RESTS_AND_RAMPS)
    for i in range(len(link.inertia)):
        yield ParameterSpec(f"inertia.{i}", "kg m^2", MASS_RANGE if i < 3 else _product_range(link), JOINT_CHIRPS)
    yield ParameterSpec("rotor_inertia", "kg m^2", factor_range(3.0, 0.01, log=False), JOINT_CHIRPS)


def _product_range(link: LinkPart) -> RangeRule:
    """Return the range of a product of inertia: the described one plus and minus its greatest in any orientation."""
    return symmetric_range(lambda _: 0.5 * max(link.inertia[:3]))


def _link_reach(link: LinkPart) -> float:
    """Return the length of a uniform rod with a link's mass and inertia, m: the reach of a last link."""
    return float(np.sqrt(3.0 * max(link.inertia[:3]) / link.mass))


def _shift_centres(machine: Machine) -> Machine:
    """Return the machine with no centre of mass on an axis, where a parameter may lack effect only by chance."""
    for number, name in enumerate(machine.arm.joints):
        link = machine.arm.link[name]
        shift = CENTRE_SHIFT_RATIO * _link_reach(link) * np.array([1.0, -0.7, 0.4]) * (1.0 + 0.1 * number)
        centre = tuple((np.array(link.centre) + shift).tolist())
        machine = replace_value(machine, ["arm", "link", name, "centre"], centre)
    return machine


def _changes_torques(machine: Machine, path: str, torques: Array) -> bool:
    """Return whether a parameter changes any of the `torques`, those of `sample_torques` of the unchanged machine."""
    changed = replace_value(machine, path.split("."), 1.5 * value_at(machine, path) + 1e-3)
    return bool(np.max(np.abs(sample_torques(changed) - torques)) > MIN_TORQUE_CHANGE * np.max(np.abs(torques)))


def sample_torques(machine: Machine) -> Array:
    """Return the torques of `TEST_MOTIONS` random motions, the same in every call, (motions, joints), N m."""
    arm, n, generator = parameters.arm(machine), len(machine.joints), np.random.default_rng(0)
    torques = []
    for _ in range(TEST_MOTIONS):
        q, v, a = generator.uniform(-1.0, 1.0, (3, n)) * [half_strokes(machine), np.ones(n), 10.0 * np.ones(n)]
        upper, moving, pulls = dynamics(arm, machine.arm.payload, tuple(q.tolist()), tuple(v.tolist()))
        mass = np.zeros((n, n))
        mass[np.triu_indices(n)] = upper
        torques.append((mass + np.triu(mass, 1).T) @ a - moving - pulls)
    return np.array(torques)


FULL_OPENING_STEPS = "steps large enough to open the valve fully, both ways"
SLOW_RAMPS = "slow ramps over the stroke, both ways"
MOTIONS_ABOUT_CENTRE = "small motions about the valve's centre"
PAUSES_OF_SECONDS = "pauses of seconds"
FAST_SAMPLED_STEPS = "steps, with the pressure sampled every few milliseconds"

DELAY_RANGE = zero_range(lambda machine, _: MAX_DELAY_CYCLES * machine.cycle)
NULL_RANGE = symmetric_range(lambda machine: 0.2 * machine.valve.volts_to_full)
OFFSET_RANGE = symmetric_range(lambda machine: 0.02 * machine.pressure_sensor.range)

VALVE_PARAMETERS = (
    ParameterSpec("valve.conductance", "m^3/(s Pa)", factor_range(3.0), FULL_OPENING_STEPS),
    ParameterSpec("valve.critical_ratio", "1", fixed_range(0.05, 0.9), "filling from low pressure and venting to it"),
    ParameterSpec("valve.leakage", "m^3/(s Pa)", factor_range(20.0, 1e-9), PAUSES_OF_SECONDS),
    ParameterSpec("valve.centre_voltage", "V", NULL_RANGE, PAUSES_OF_SECONDS),
    ParameterSpec("valve.volts_to_full", "V", factor_range(2.0), "voltages beyond full opening"),
    ParameterSpec("valve.delay", "s", DELAY_RANGE, "steps, and chirps up to 3 Hz"),
)
SPOOL_PARAMETERS = (
    ParameterSpec("valve.overlap", "1", fixed_range(0.0, 0.3), MOTIONS_ABOUT_CENTRE),
    ParameterSpec("valve.natural_frequency", "Hz", factor_range(4.0), FAST_SAMPLED_STEPS),
)
SWITCHING_PARAMETERS = (
    ParameterSpec("valve.dead_band", "1", fixed_range(0.0, 0.3), MOTIONS_ABOUT_CENTRE),
    ParameterSpec("valve.opening_delay", "s", factor_range(3.0), "pulses of all lengths"),
    ParameterSpec("valve.closing_delay", "s", factor_range(3.0), "pulses of all lengths"),
)
HOSE_PARAMETERS = (
    ParameterSpec("hose.torque_factor", "1", factor_range(2.0), "fast moves with a known payload, and without"),
    ParameterSpec("hose.dead_volume", "m^3", factor_range(3.0), FULL_OPENING_STEPS),
    ParameterSpec("hose.compliance", "m^3/Pa", factor_range(10.0, 1e-10), "filling from low pressure"),
    ParameterSpec("hose.wall_conductance", "W/K", factor_range(10.0, 10.0), "fast filling, then pauses of seconds"),
)
LOSS_PARAMETERS = (
    ParameterSpec("hose.loss_fraction", "1", factor_range(3.0, 0.5, upper=1.0), SLOW_RAMPS),
    ParameterSpec("losses.pressure_free", "1", fixed_range(0.0, 1.0), f"{SLOW_RAMPS}, at two supply pressures"),
    ParameterSpec("losses.deflections.0", "rad", factor_range(5.0), "small motions to and fro"),
    ParameterSpec("losses.deflections.1", "rad", factor_range(5.0), "motions of a few degrees to and fro"),
    ParameterSpec("losses.deflections.2", "rad", factor_range(4.0), "slow ramps of several sizes"),
)
FRICTION_PARAMETERS = (
    ParameterSpec("brake.torque", "N m", factor_range(5.0, 5.0), SLOW_RAMPS),
    ParameterSpec("brake.viscous", "N m s/rad", factor_range(20.0, 1.0), "chirps up to 3 Hz"),
)
STRIBECK_PARAMETERS = (
    ParameterSpec("friction.static_ratio", "1", fixed_range(1.0, 3.0), f"{SLOW_RAMPS}, with pauses"),
    ParameterSpec("friction.velocity", "rad/s", factor_range(10.0), f"{SLOW_RAMPS}, with pauses"),
    ParameterSpec("friction.load_ratio", "1", fixed_range(0.0, 0.3), f"{SLOW_RAMPS}, at two supply pressures"),
)
LINE_PARAMETERS = (
    ParameterSpec("line.length", "m", factor_range(3.0), f"{FULL_OPENING_STEPS}, and chirps up to 3 Hz"),
    ParameterSpec("line.bore", "m", factor_range(2.0), FULL_OPENING_STEPS),
)
INERTIA_PARAMETERS = (ParameterSpec("link.inertia", "kg m^2", MASS_RANGE, "chirps up to 3 Hz without payload"),)
PAYLOAD_PARAMETER = ParameterSpec(
    "arm.payload", "kg", zero_range(lambda _, guess: max(3.0 * guess, 2.0)), "chirps up to 3 Hz"
)
SENSOR_PARAMETER = ParameterSpec("pressure_sensor.offset", "Pa", OFFSET_RANGE, "both pressures by themselves")

PARAMETERS_BY_JOINT = {
    "hose": HOSE_PARAMETERS,
    "losses": LOSS_PARAMETERS,
    "friction": FRICTION_PARAMETERS,
    "inertia": INERTIA_PARAMETERS,
}
MACHINE_BLOCKS = ("valve", *PARAMETERS_BY_JOINT, "line", "payload", "sensors")  # of a machine that moves


def machine_unknowns(machine: Machine, blocks: Sequence[str]) -> list[Unknown]:
    """Return the unknowns of a machine in these blocks, in their order.

    Raises:
        InputError: there is no block, one is unknown, or it is `line` and the machine has no line.
    """
    if not blocks:
        raise InputError("names no block", where="blocks", right=f"choose from {', '.join(MACHINE_BLOCKS)}")
    of_kind = SWITCHING_PARAMETERS if isinstance(machine.valve, SwitchingValvesPart) else SPOOL_PARAMETERS
    specs = {"valve": [*VALVE_PARAMETERS, *of_kind], "payload": [PAYLOAD_PARAMETER], "sensors": [SENSOR_PARAMETER]}
    for block, shared in PARAMETERS_BY_JOINT.items():
        specs[block] = [
            spec._replace(path=f"joint.{name}.{spec.path}")
            for name, joint in machine.joints.items()
            for spec in (
                *shared,
                *(STRIBECK_PARAMETERS if block == "friction" and isinstance(joint.friction, StribeckPart) else ()),
            )
        ]
    if machine.arm.own_links:
        specs["inertia"] = link_parameters(machine)
    specs["line"] = _line_parameters(machine)
    if "line" in blocks and not specs["line"]:
        raise InputError(
            "has no line", where=machine.origin, right="describe its [line], or leave line out of `blocks`"
        )
    return [
        spec.unknown(machine)
        for block in check_choices(blocks, MACHINE_BLOCKS, "blocks", "block")
        for spec in specs[block]
    ]


def _line_parameters(machine: Machine) -> list[ParameterSpec]:
    """Return the parameters of the machine's line, if a joint has none of its own, then those of joints' lines."""
    shared = machine.line is not None and any(joint.line is None for joint in machine.joints.values())
    prefixes = [f"joint.{name}." for name, joint in machine.joints.items() if joint.line is not None]
    prefixes = ([""] if shared else []) + prefixes
    return [spec._replace(path=f"{prefix}{spec.path}") for prefix in prefixes for spec in LINE_PARAMETERS]
