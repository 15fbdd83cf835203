"""Size an arm: from what it is to do to its joints, links and masses, as a description that simulates at once.

Joints carry the joints after them, and have to be as strong as these are heavy, which they add to. So sizing goes
through the arm, from joints that are as small as any, until each gives what the moves of the task ask of it with the
arm as it then is. Joints only grow, in steps of whole millimetres of their cylinders, so this ends: with an arm that
is no heavier than it has to be, or at a joint that no hose is wide enough for.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Unpack

import numpy as np

from layflat.design.arm.components import choose_tube, choose_valve, sold_valves, valve_sizes
from layflat.design.arm.described import SizedPart, description_text, joint_tables, make_machine
from layflat.design.arm.moves import TaskMoves, plan_task_moves
from layflat.design.arm.task import ArmTask, JointTask, TaskFields, read_task
from layflat.design.joint import design_joint
from layflat.design.request import CHOSEN_RATIO, CONTACT_SHARE, FIELD_RANGES, HOSE_WIDTHS, TRAVEL_RESERVE, SizingRequest
from layflat.design.sized import BRAKE_SHARE
from layflat.design.sizing import model_machine, size_joint
from layflat.design.summary import Finding, JointDesign
from layflat.errors import DesignError
from layflat.files import write_text
from layflat.keywords import with_keywords_of
from layflat.machine import Machine
from layflat.machine.parameters import loss_fraction
from layflat.motion.dynamics import rigid_torques
from layflat.physics.hose import HoseGeometry
from layflat.plot.tables import html_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEAST_TORQUE = 1.0  # of a sized joint, N m
USABLE_SHARE = 0.92  # differential pressure that a moving joint reaches, over the supply's gauge pressure


class TorqueNeed(NamedTuple):
    """Max load of a joint in the moves of a task, without margin."""

    torque: float  # N m
    static: float  # of gravity alone, N m
    speed: float  # rad/s


@dataclass(frozen=True)
class SizedArm:
    """Arm that is sized for a task."""

    task: ArmTask
    moves: TaskMoves
    parts: tuple[SizedPart, ...]  # from base to tip
    needs: tuple[TorqueNeed, ...]
    required_torques: tuple[float, ...]  # required torque of each joint at supply pressure, N m
    toml: str  # description, each value with its provenance
    machine: Machine  # of this description

    @property
    def mass(self) -> float:
        """Mass of all joints and links, kg."""
        return sum(part.mass + part.tube.mass for part in self.parts)

    @cached_property
    def designs(self) -> tuple[JointDesign, ...]:
        """Designs of the joints, as parts of the arm."""
        return tuple(design_joint(self.machine, part.task.name) for part in self.parts)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Warnings and notes of the design rules, joint by joint."""
        return tuple(finding for design in self.designs for finding in design.findings)

    def write(self, path: Path) -> Path:
        """Write the description to a TOML file; raise OutputError if it can't be written there."""
        return write_text(path, self.toml)

    def plot(self) -> "Figure":
        """Draw the arm in mid-stroke, from the side and from above, with the ends of its task's moves."""
        from layflat.design.arm.picture import draw_arm  # noqa: PLC0415
        from layflat.plot.style import add_caption  # noqa: PLC0415  # matplotlib takes long to import

        return add_caption(draw_arm(self.machine, self.parts, self.moves), f"{self._title}, {self.mass:.2f} kg in all")

    def _repr_html_(self) -> str:
        """Return a table of the joints' torques and masses, for notebooks."""
        columns = ("joint", "holds (N m)", "moves (N m)", "with margin (N m)", "gives (N m)", "mass (kg)")
        rows = [
            (
                part.task.name,
                *(f"{torque:.1f}" for torque in (need.static, need.torque, wanted, part.torque)),
                f"{part.mass:.2f}",
            )
            for part, need, wanted in zip(self.parts, self.needs, self.required_torques, strict=True)
        ]
        return html_table(self._title, columns, rows)

    @property
    def _title(self) -> str:
        return f"{self.machine.name}: {self.task.payload:.3g} kg at {self.task.supply / 1e5:g} bar"


@with_keywords_of(ArmTask)
def size_arm(
    task: str | Path | ArmTask | None = None,
    *,
    progress: Callable[[int], None] = lambda _: None,
    **values: Unpack[TaskFields],
) -> SizedArm:
    """Size an arm for a task: repeat the sizing of all joints until their torques carry their masses too.

    Args:
        task: a task, its file, or the name of a built-in one; default: a task of `values` alone.
        progress: called with the number of each iteration.
        **values: texts with units by the keys of a task's file, for instance `reach="0.9 m"`, `payload="1 kg"`,
            `supply="6 bar"`, `time="1 s"`; they replace those of the file.

    Raises:
        DesignError: the task is wrong; a joint needs more torque than any hose yields, or the arm does not reach a
            point of the task.

    Example:
        >>> import layflat as lf
        >>> arm = lf.size_arm(reach="0.6 m", joints=2, payload="1 kg", supply="6 bar", time="1 s")
        >>> list(arm.machine.joints), arm.mass
        (['shoulder', 'elbow'], 1.53)
    """
    if isinstance(task, ArmTask) and values:
        raise DesignError(f"stands beside {next(iter(values))}", where="task", right="give one or the other")
    return size_for_moves(task if isinstance(task, ArmTask) else read_task(task, **values), progress=progress)


def size_for_moves(
    task: ArmTask, moves: TaskMoves | None = None, *, progress: Callable[[int], None] = lambda _: None
) -> SizedArm:
    """Size an arm as `size_arm` does, for moves that are planned already.

    Args:
        task: task of the arm.
        moves: moves of this task; default: planned here.
        progress: called with the number of each iteration.

    Raises:
        DesignError: as `size_arm`.
    """
    parts, rounds = [_size_part(task, joint, LEAST_TORQUE) for joint in task.chain], 0
    while True:
        machine = make_machine(task, parts)
        moves = moves or plan_task_moves(task, machine)
        needs = _torque_needs(task, machine, moves)
        required = [_required_torque(task, part, need) for part, need in zip(parts, needs, strict=True)]
        grown = [
            part if torque <= part.torque else _size_part(task, part.task, torque)
            for part, torque in zip(parts, required, strict=True)
        ]
        if grown == parts:
            fitted = _choose_valves(task, moves, parts, machine)
            machine, text = make_machine(task, fitted), description_text(task, fitted)
            return SizedArm(task, moves, fitted, tuple(needs), tuple(required), text, machine)
        parts, rounds = grown, rounds + 1
        progress(rounds)


def _size_part(task: ArmTask, joint: JointTask, torque: float) -> SizedPart:
    """Return a joint sized for a torque (N m), with the tube of its link.

    Raises:
        DesignError: the widest hose gives less torque, or no such joint can be made.
    """
    where = f"{task.origin}: joint {joint.name!r}"
    try:
        greatest = _max_hose_torque(joint, task.supply)
        if torque > greatest:
            need = f"would have to give at least {torque:.0f} N m over {degrees(joint.stroke):.0f} deg"
            what = f"{need} at {task.supply / 1e5:.3g} bar, {torque / greatest:.2f} times what the widest hose gives"
            raise DesignError(what, right="ask for less reach, payload or speed, or give more pressure")
        sized = size_joint(SizingRequest(torque, joint.stroke, task.supply, name=joint.name))
    except DesignError as error:
        key = error.where.removeprefix("size").removeprefix(": ")
        right = "give it a longer stroke" if key == "stroke" else error.right  # a task says nothing of the wrap
        raise DesignError(f"{key}: {error.what}" if key else error.what, where=where, right=right) from None
    return SizedPart(joint, sized, choose_tube(joint.link, sized.design.mean_torque, where), joint_tables(sized))


def _max_hose_torque(joint: JointTask, supply: float) -> float:
    """Return the torque of the widest hose over a stroke, N m, at most the largest that a `SizingRequest` takes."""
    request = SizingRequest(LEAST_TORQUE, joint.stroke, supply)
    (base,), wide = model_machine().joints.values(), HOSE_WIDTHS[-1]
    R, gamma = CHOSEN_RATIO[1] * wide / 2, request.wrap
    hose = HoseGeometry(wide, R, gamma, CONTACT_SHARE * gamma, base.hose.peel_ratio)
    return min(hose.volume * supply / (joint.stroke + TRAVEL_RESERVE), FIELD_RANGES["torque"][2])


def _torque_needs(task: ArmTask, machine: Machine, moves: TaskMoves) -> list[TorqueNeed]:
    """Return each joint's greatest torque in the moves, greatest torque at rest, and greatest speed."""
    states = moves.states
    moving = np.abs(rigid_torques(machine, states, task.payload))
    still = states._replace(velocities=0.0 * states.velocities, accelerations=0.0 * states.accelerations)
    static = np.abs(rigid_torques(machine, still, task.payload))
    rows = moving.max(axis=0), static.max(axis=0), np.abs(states.velocities).max(axis=0)
    return [TorqueNeed(*map(float, row)) for row in zip(*rows, strict=True)]


def _required_torque(task: ArmTask, part: SizedPart, need: TorqueNeed) -> float:
    """Return the torque at supply pressure that a joint needs, with margin, friction and losses, N m."""
    (joint,) = part.joint.machine.joints.values()
    left = USABLE_SHARE * (1.0 - BRAKE_SHARE - 0.5 * float(loss_fraction(joint)))
    return task.margin * need.torque / left


def _choose_valves(
    task: ArmTask, moves: TaskMoves, parts: Sequence[SizedPart], machine: Machine
) -> tuple[SizedPart, ...]:
    """Return the parts with the smallest sold valves that feed the moves, with the task's margin.

    Raise DesignError if no valve is large enough for a joint.
    """
    sold, sizes = sold_valves(machine), task.margin * valve_sizes(machine, moves, task.payload)
    return tuple(
        part._replace(valve=choose_valve(sold, float(size), f"{task.origin}: joint {part.task.name!r}"))
        for part, size in zip(parts, sizes, strict=True)
    )
