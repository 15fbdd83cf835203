"""What can be fitted of the links of an arm in space: where their masses are, and how far they spread.

A joint feels of the links after it what its own turn moves, so that some values act on no joint at all (the height of a
base that turns about an upright axis) and others only together (the mass of a link and where that of the link before
it is). The first are left out here; of the others a fit says so.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from layflat.arrays import Array
from layflat.description.change import replaced, value_at
from layflat.identify.model import Flags
from layflat.identify.unknown import ParameterSpec, Range, around, factor_range
from layflat.machine import Machine, parameters
from layflat.physics.arms import dynamics
from layflat.physics.arms.chain.description import LinkPart, six_moments

RESTS = "rests and slow ramps in many postures of all joints"
SWINGS = "chirps up to 3 Hz of all joints, one after the other, without payload"
SCALES = "the weight of the link by itself"

MASSES = factor_range(3.0, 0.1, log=False)  # what adds to something known does not change by factors
THICK, THIN = 1e-3, 1e-7  # least spread of mass along a direction over the greatest: usual, and of a thin body
SMALL = 1e-2  # share of the described spread that a body has at least along one direction
TURNS = 30  # in which a possible inertia is looked for that keeps what is sought
LOOKS = 3  # motions by which it is seen whether a value acts on any joint
ASIDE = 0.1  # of a link's size, by which its centre is then moved
FELT = 1e-9  # share of the torques by which it then changes them at least


def links(machine: Machine) -> list[ParameterSpec]:
    """What is looked for of every link, from the base on; nothing of an arm that has its links in its joints."""
    if not machine.arm.own_links:
        return []
    ends = [machine.arm.link[name].place for name in machine.arm.joints[1:]] + [machine.arm.tool]
    crooked = _crooked(machine)
    usual = some_torques(crooked)
    return [
        spec._replace(path=f"arm.link.{name}.{spec.path}")
        for name, end in zip(machine.arm.joints, ends, strict=True)
        for spec in _of_link(machine.arm.link[name], max(float(np.linalg.norm(end)), _size(machine.arm.link[name])))
        if _acts(crooked, f"arm.link.{name}.{spec.path}", usual)
    ]


def _of_link(link: LinkPart, length: float) -> Iterator[ParameterSpec]:
    yield ParameterSpec("mass", "kg", MASSES, SCALES)
    for i in range(3):
        yield ParameterSpec(f"centre.{i}", "m", around(lambda _: 0.5 * length), RESTS)
    for i in range(len(link.inertia)):
        yield ParameterSpec(f"inertia.{i}", "kg m^2", MASSES if i < 3 else _product(link), SWINGS)
    yield ParameterSpec("rotor_inertia", "kg m^2", factor_range(3.0, 0.01, log=False), SWINGS)


def _product(link: LinkPart) -> Range:
    """Of a product of inertia: as far as it could be if the body were turned any way."""
    return around(lambda _: 0.5 * max(link.inertia[:3]))


def _size(link: LinkPart) -> float:
    """How far a link reaches if nothing follows on it, from how its mass is spread, m."""
    return float(np.sqrt(3.0 * max(link.inertia[:3]) / link.mass))


def _crooked(machine: Machine) -> Machine:
    """The machine with no mass on any axis, where a value may be without effect only by chance."""
    for number, name in enumerate(machine.arm.joints):
        link = machine.arm.link[name]
        shift = ASIDE * _size(link) * np.array([1.0, -0.7, 0.4]) * (1.0 + 0.1 * number)
        centre = tuple((np.array(link.centre) + shift).tolist())
        machine = replaced(machine, ["arm", "link", name, "centre"], centre)
    return machine


def _acts(machine: Machine, path: str, usual: Array) -> bool:
    """Whether a value changes the usual torques of any motion."""
    changed = replaced(machine, path.split("."), 1.5 * value_at(machine, path) + 1e-3)
    return bool(np.max(np.abs(some_torques(changed) - usual)) > FELT * np.max(np.abs(usual)))


def some_torques(machine: Machine) -> Array:
    """Torques of a few random motions, (motions, joints), N m."""
    arm, n, draw = parameters.arm(machine), len(machine.joints), np.random.default_rng(0)
    halves = [0.5 * joint.stops.working_stroke for joint in machine.joints.values()]
    found = []
    for _ in range(LOOKS):
        q, v, a = draw.uniform(-1.0, 1.0, (3, n)) * [halves, np.ones(n), 10.0 * np.ones(n)]
        upper, moving, pulls = dynamics(arm, machine.arm.payload, tuple(q.tolist()), tuple(v.tolist()))
        mass = np.zeros((n, n))
        mass[np.triu_indices(n)] = upper
        found.append((mass + np.triu(mass, 1).T) @ a - moving - pulls)
    return np.array(found)


def possible(machine: Machine, columns: Mapping[str, Array]) -> dict[str, Array]:
    """Values of candidates by path, with inertias that bodies can have in place of those that none can.

    A body's mass spreads along three directions at right angles; where it would spread along one by less than nothing,
    it does by next to nothing instead. What acts on no joint gives way first, and is then among the values.
    """
    found = dict(columns)
    for name in machine.arm.joints if machine.arm.own_links else ():
        described = machine.arm.link[name].inertia
        paths = [f"arm.link.{name}.inertia.{i}" for i in range(len(described))]
        sought = np.array([path in columns for path in paths] + [False] * (6 - len(paths)))
        if sought.any():
            given = [columns.get(path, value) for path, value in zip(paths, described, strict=True)]
            moments = np.array(np.broadcast_arrays(*six_moments(tuple(given)), columns[paths[int(np.argmax(sought))]]))
            nearest = _nearest(moments[:6], sought, described)
            changed = np.any(nearest != moments[:6], axis=1)
            found |= {path: nearest[i] for i, path in enumerate(paths) if sought[i] or changed[i]}
    return found


def _nearest(asked: Array, sought: Flags, described: Sequence[float]) -> Array:
    """Inertias (6, candidates) of bodies near those asked for, no thinner than the described one where that is thin.

    By turns the nearest body is taken, and what is sought of it put back as it was asked for.
    """
    usual = np.linalg.eigvalsh(_spread(np.array(six_moments(tuple(described)))[:, None]))[0]
    found, turns = asked, 1 if sought.all() else TURNS
    for turn in range(turns):
        values, vectors = np.linalg.eigh(_spread(found))
        most = np.maximum(values[:, -1], SMALL * usual[-1])
        least = np.minimum(THICK * most, np.maximum(usual[0], THIN * most))
        poor = values[:, 0] < least
        if not poor.any():
            break
        spread = (vectors * np.maximum(values, 2.0 * least[:, None])[:, None, :]) @ vectors.swapaxes(1, 2)
        turned = np.trace(spread, axis1=1, axis2=2)[:, None, None] * np.eye(3) - spread
        nearest = np.array([turned[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))])
        kept = asked if turn < turns - 1 else nearest
        found = np.where(poor, np.where(sought[:, None], kept, nearest), found)
    return found


def _spread(inertia: Array) -> Array:
    """Second moments of mass about the centre, (candidates, 3, 3), kg m2, from moments and products of inertia."""
    xx, yy, zz, xy, xz, yz = inertia
    moments = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(-1, 3, 3)
    return np.asarray(0.5 * np.trace(moments, axis1=1, axis2=2)[:, None, None] * np.eye(3) - moments)
