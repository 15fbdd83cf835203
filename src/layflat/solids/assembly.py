"""The assembly of a machine: components of all joints, links, foot and tool flange at angles of the joints."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from layflat.bridge.pieces import rigid_arm
from layflat.errors import DesignError, InputError
from layflat.lazy import numpy as np
from layflat.physics.arms.bodies import RigidArm, RigidLink
from layflat.solids import cad
from layflat.solids.joint import joint_sizes
from layflat.solids.kernel import Integrals, integrals, placed
from layflat.solids.links import Seat, arm_seats, arm_tie, flange, foot_components, strut_components
from layflat.solids.mends import buildable_components
from layflat.solids.output import arm_reach
from layflat.solids.places import foot_places, tongue_holes
from layflat.solids.shapes import PartPlace
from layflat.solids.sizes import MM, JointSizes
from layflat.solids.volumes import lowest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from layflat.arrays import Array
    from layflat.machine import Machine
    from layflat.solids.component import Component
    from layflat.solids.shapes import Shape

MAX_ACROSS_COSINE = 0.5  # most that the cosine between axes that count as across is
LEAST_PARALLEL_COSINE = 0.999  # least cosine between axes that count as parallel
LEAST_ACROSS = 1e-3  # least length across a joint's axis of a direction to what comes next, over its length
SENSOR_HEIGHT = 40.0  # that a joint takes above its upper end plate, mm
SHELL_SWING = 0.45  # that shells swing out beyond the rim over the cylinder's radius


@dataclass(frozen=True)
class Assembly:
    """Components of a machine in the frame of its base, mm, at angles of its joints."""

    machine: Machine
    angles: tuple[float, ...]  # of the joints from mid-stroke, rad
    sizes: dict[str, JointSizes]  # by name of the joint
    components: tuple[Component, ...]
    omitted: dict[str, str]  # joints of a kind without solids, and why

    @cached_property
    def _solids(self) -> dict[Shape, Any]:
        return {}

    @cached_property
    def _integrals(self) -> dict[Shape, Integrals]:
        return {}

    def solid(self, component: Component) -> Any:
        """Return the solid of a component in its own frame, mm."""
        return self.shape_solid(component.shape)

    def shape_solid(self, shape: Shape) -> Any:
        """Return the solid of a shape, mm, made once."""
        if shape not in self._solids:
            self._solids[shape] = cad.solid(shape)
        return self._solids[shape]

    def mass_of(self, component: Component) -> float:
        """Return the mass of one part of a component, kg: as bought, or of its solid."""
        if component.bought_mass is not None:
            return component.bought_mass
        return self.integrals(component.shape).volume / MM**3 * component.density

    def integrals(self, shape: Shape) -> Integrals:
        """Return the integrals over a shape's solid, computed once."""
        if shape not in self._integrals:
            self._integrals[shape] = integrals(self.shape_solid(shape))
        return self._integrals[shape]

    def bodies(self) -> Iterator[tuple[Component, int, Any]]:
        """Yield each part as its component, its number among the component's parts, and its solid at its place."""
        for component in self.components:
            for number, at in enumerate(component.places):
                yield component, number, placed(self.solid(component), at)

    def build(self, progress: Callable[[int, int], object] = lambda _done, _all: None) -> None:
        """Make all solids; `progress` is called with how many are made, and of how many."""
        for done, component in enumerate(self.components):
            progress(done, len(self.components))
            self.solid(component)
        progress(len(self.components), len(self.components))


def assemble(machine: Machine, angles: Sequence[float] | None = None, *, mend: bool = False) -> Assembly:
    """Return the assembly of a machine; solids are made when they are asked for.

    Args:
        machine: the machine.
        angles: of its joints from mid-stroke, rad; default: all in mid-stroke.
        mend: whether to look for values that mend a joint which can't be built, which can take seconds.

    Raises:
        InputError: the number of angles is not that of the joints, or one is beyond the mechanical stroke.
        DesignError: no size keeps a rule; the message says which value would mend it, if that is looked for.
    """
    chosen = _checked_angles(machine, angles)
    arm = rigid_arm(machine)
    frames = [_frame(arm, k) for k in range(len(arm.links))]
    sizes, omitted = _all_sizes(machine, arm, frames)
    poses = [PartPlace(axes, MM * origin) for axes, origin in arm.poses(chosen)]
    found: list[Component] = []
    names = list(machine.joints)
    for k, (name, angle) in enumerate(zip(names, chosen, strict=True)):
        if name not in sizes:
            continue
        turned = arm.links[k]
        base = poses[k - 1] if k else PartPlace(np.eye(3), np.zeros(3))
        # The joint's body moves with the link before: where the link after it is in mid-stroke.
        rest = PartPlace(turned.axes, MM * turned.place).then(base)
        after = sizes.get(names[k + 1]) if k + 1 < len(names) else None
        own = _lowered(sizes[name], after, arm, k)
        body = _joint_place(frames[k], sizes[name], own).then(rest)
        parts = buildable_components(sizes[name], angle, mend=mend)
        if sizes[name].foot:
            low = min(lowest(part.shape, at) for part in parts for at in part.places)
            parts += foot_components(sizes[name], foot_places(sizes[name]), low)
        found += [replace(part.moved(body), joint=name) for part in parts]
        output = PartPlace(frames[k], -own * frames[k][:, 2]).then(poses[k])
        link = _link(machine, arm, frames, sizes, k, own)
        link += arm_tie(sizes[name], linked=bool(link))
        found += [replace(part.moved(output), joint=name) for part in link]
    return Assembly(machine, tuple(chosen), sizes, tuple(found), omitted)


def _checked_angles(machine: Machine, angles: Sequence[float] | None) -> list[float]:
    joints = list(machine.joints.items())
    chosen = [0.0] * len(joints) if angles is None else [float(angle) for angle in angles]
    if len(chosen) != len(joints):
        right = f"give one for each of {', '.join(name for name, _ in joints)}"
        raise InputError(f"{len(chosen)} angles for {len(joints)} joints", where="angles", right=right)
    for (name, joint), angle in zip(joints, chosen, strict=True):
        limit = joint.stops.mechanical_stroke / 2
        if not abs(angle) <= limit * (1 + 1e-9):
            what = f"{np.degrees(angle):.4g} deg for {name}"
            right = f"the mechanical stroke goes from {-np.degrees(limit):.4g} to {np.degrees(limit):.4g} deg"
            raise InputError(what, where="angles", right=right)
    return chosen


def _frame(arm: RigidArm, k: int) -> Array:
    """Return the axes of the output's frame in its link's, (3, 3): z along the axis, y towards what comes next."""
    link = arm.links[k]
    after = arm.links[k + 1] if k + 1 < len(arm.links) else None
    z = link.axis
    ahead = arm.tool if after is None else after.place
    across = ahead - (ahead @ z) * z
    if np.linalg.norm(across) <= LEAST_ACROSS * max(float(np.linalg.norm(ahead)), 1e-9) and after is not None:
        across = np.cross(after.axes @ after.axis, z)
    if np.linalg.norm(across) <= LEAST_ACROSS:
        across = np.eye(3)[int(np.argmin(np.abs(z)))]
        across = across - (across @ z) * z
    y = across / np.linalg.norm(across)
    return np.column_stack([np.cross(y, z), y, z])


def _all_sizes(machine: Machine, arm: RigidArm, frames: list[Array]) -> tuple[dict[str, JointSizes], dict[str, str]]:
    """Return the sizes of all joints that have solids, and why the others have none."""
    sizes: dict[str, JointSizes] = {}
    omitted: dict[str, str] = {}
    for k, name in enumerate(machine.joints):
        one = joint_sizes(machine, name)
        try:
            one.line  # noqa: B018  # refuses straps that a roller deflects
        except DesignError as error:
            omitted[name] = str(error)
            continue
        if k == 0:
            sizes[name] = replace(one, foot=True)
            continue
        before = sizes.get(list(machine.joints)[k - 1])
        sizes[name] = replace(one, mount=_mount(arm, frames, before, one, k))
    return sizes, omitted


def _mount(arm: RigidArm, frames: list[Array], before: JointSizes | None, after: JointSizes, k: int) -> float:
    """Return the direction of a joint's tongues in its own frame, rad: towards the arm plates of the joint before.

    Where that has no solids, they point to its axis.
    """
    link: RigidLink = arm.links[k]
    axes = link.axes @ frames[k]
    centre = MM * link.place - axes @ np.array([0.0, after.axis, 0.0])
    start = np.zeros(3)
    if before is not None:
        start = frames[k - 1] @ np.array([0.0, arm_reach(before), -_lowered(before, after, arm, k - 1)])
    towards = axes.T @ (start - centre)
    return float(np.arctan2(towards[1], towards[0]))


def _lowered(sizes: JointSizes, other: JointSizes | None, arm: RigidArm, k: int) -> float:
    """Return how far joint k is shifted down along its axis, mm, so that a next one across it swings freely above."""
    if other is None:
        return 0.0
    link, after = arm.links[k], arm.links[k + 1]
    if abs(float((after.axes @ after.axis) @ link.axis)) > MAX_ACROSS_COSINE:
        return 0.0
    height = MM * float(after.place @ link.axis)
    reach = other.axis + other.rim + SHELL_SWING * other.radius
    return max(0.0, sizes.top + SENSOR_HEIGHT + reach - height)


def _joint_place(frame: Array, sizes: JointSizes, lowered: float) -> PartPlace:
    """Return the place of a joint's frame in that of the link that it turns, in mid-stroke."""
    return PartPlace(frame, -frame @ np.array([0.0, sizes.axis, lowered]))


def _link(
    machine: Machine, arm: RigidArm, frames: list[Array], sizes: dict[str, JointSizes], k: int, lowered: float
) -> list[Component]:
    """Return struts and flange of the link that joint k turns, in the frame of its output."""
    names = list(machine.joints)
    one, frame = sizes[names[k]], frames[k]
    down = np.array([0.0, 0.0, lowered])
    if k + 1 == len(names):
        at = MM * frame.T @ arm.tool + down
        along = np.array([0.0, 1.0, 0.0])
        if float(np.hypot(*at[:2])) < arm_reach(one) + one.arm_width:
            return []
        part, seats = flange(one, at, along)
        return [part, *strut_components(one, list(zip(arm_seats(one, outer=True), seats, strict=True)))]
    if names[k + 1] not in sizes:
        return []
    after, other = arm.links[k + 1], sizes[names[k + 1]]
    into = PartPlace(frame.T @ after.axes @ frames[k + 1], frame.T @ (MM * after.place) + down)
    following = sizes.get(names[k + 2]) if k + 2 < len(names) else None
    shift = np.array([0.0, other.axis, _lowered(other, following, arm, k + 1)])
    into = PartPlace(into.axes, into.origin - into.axes @ shift)
    seats = tongue_seats(other, into)
    outer = arm_seats(one, outer=True)
    if abs(float(into.axes[2, 2])) > LEAST_PARALLEL_COSINE:
        ordered = seats if into.axes[2, 2] > 0 else seats[::-1]
        return strut_components(one, list(zip(outer, ordered, strict=True)))
    return strut_components(one, list(zip(outer, seats, strict=True)))


def tongue_seats(sizes: JointSizes, into: PartPlace) -> list[Seat]:
    """Return the seats on the outer faces of the tongues of the upper and lower end plate, in another frame.

    Args:
        sizes: sizes of the joint that has the tongues.
        into: place of its frame in the other one.
    """
    (x0, y0), (x1, y1) = tongue_holes(sizes)
    found = []
    for s in (1.0, -1.0):
        far, near = (into.origin + into.axes @ np.array([x, y, s * sizes.top]) for x, y in ((x0, y0), (x1, y1)))
        normal, edge = s * into.axes[:, 2], sizes.arm_width / 2
        found.append(Seat(near, far, normal, edge, sizes.end_plate, sizes.screw, tapped=True))
    return found
