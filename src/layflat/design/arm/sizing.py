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
from typing import NamedTuple

import numpy as np

from layflat.design.arm.described import Part, machine_of, said_of, text_of
from layflat.design.arm.links import tube
from layflat.design.arm.moves import Moves, moves_of
from layflat.design.arm.task import ArmTask, JointTask
from layflat.design.arm.valves import choose, sold_valves, valve_sizes
from layflat.design.findings import Finding
from layflat.design.joint import design_joint
from layflat.design.request import CHOSEN_RATIO, CONTACT_SHARE, HOSE_WIDTHS, RANGES, RESERVE, SizingRequest
from layflat.design.sized import BRAKE_SHARE
from layflat.design.sizing import model, size_joint
from layflat.design.summary import JointDesign
from layflat.errors import DesignError
from layflat.files import write_text
from layflat.machine import Machine
from layflat.machine.parameters import loss_share
from layflat.motion.dynamics import rigid_torques
from layflat.physics.hose import HoseGeometry

LEAST_TORQUE = 1.0  # for which a joint is made, N m
USABLE = 0.92  # share of the supply's pressure that a differential pressure comes to while a joint moves


class Need(NamedTuple):
    """Load of a joint in the moves of a task, without margin."""

    torque: float  # greatest, N m
    static: float  # of gravity alone, N m
    speed: float  # rad/s


@dataclass(frozen=True)
class SizedArm:
    """An arm that was sized."""

    task: ArmTask
    moves: Moves
    parts: tuple[Part, ...]  # from base to tip
    needs: tuple[Need, ...]
    wanted: tuple[float, ...]  # torque that each joint has to give at supply pressure, N m
    toml: str  # its description, each value with its provenance
    machine: Machine  # that this text describes

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
        return tuple(found for design in self.designs for found in design.findings)

    def write(self, path: Path) -> Path:
        """Write the description to a TOML file; raise OutputError if it can't be written there."""
        return write_text(path, self.toml)


def size_arm(task: ArmTask, *, moves: Moves | None = None, tell: Callable[[int], None] = lambda _: None) -> SizedArm:
    """Size an arm for a task.

    Args:
        task: what it is to do.
        moves: of this task, where they are known.
        tell: is called with the number of each round through the arm.

    Raises:
        DesignError: a joint would have to give more than any of its kind can, or the arm does not reach where it is to.
    """
    parts, rounds = [_part(task, joint, LEAST_TORQUE) for joint in task.chain], 0
    while True:
        machine = machine_of(task, parts)
        moves = moves or moves_of(task, machine)
        needs = _needs(task, machine, moves)
        wanted = [_wanted(task, *of) for of in zip(parts, needs, strict=True)]
        grown = [
            part if torque <= part.torque else _part(task, part.task, torque)
            for part, torque in zip(parts, wanted, strict=True)
        ]
        if grown == parts:
            fitted = _with_valves(task, moves, parts, machine)
            machine, text = machine_of(task, fitted), text_of(task, fitted)
            return SizedArm(task, moves, fitted, tuple(needs), tuple(wanted), text, machine)
        parts, rounds = grown, rounds + 1
        tell(rounds)


def _part(task: ArmTask, joint: JointTask, torque: float) -> Part:
    where = f"{task.origin}: joint {joint.name!r}"
    try:
        greatest = _greatest(joint, task.supply)
        if torque > greatest:
            asked = f"would have to give at least {torque:.0f} N m over {degrees(joint.stroke):.0f} deg"
            what = f"{asked} at {task.supply / 1e5:.3g} bar, {torque / greatest:.2f} times what the widest hose gives"
            raise DesignError(what, right="ask for less reach, payload or speed, or give more pressure")
        sized = size_joint(SizingRequest(torque, joint.stroke, task.supply, name=joint.name))
    except DesignError as error:
        key = error.where.removeprefix("size").removeprefix(": ")
        right = "give it a longer stroke" if key == "stroke" else error.right  # a task says nothing of the wrap
        raise DesignError(f"{key}: {error.what}" if key else error.what, where=where, right=right) from None
    return Part(joint, sized, tube(joint.link, sized.design.mean_torque, where), said_of(sized))


def _greatest(joint: JointTask, supply: float) -> float:
    """Return the torque of the widest hose over a stroke, N m."""
    request = SizingRequest(LEAST_TORQUE, joint.stroke, supply)
    (base,), wide = model().joints.values(), HOSE_WIDTHS[-1]
    R, gamma = CHOSEN_RATIO[1] * wide / 2, request.wrap
    hose = HoseGeometry(wide, R, gamma, CONTACT_SHARE * gamma, base.hose.peel_ratio)
    return min(hose.volume * supply / (joint.stroke + RESERVE), RANGES["torque"][2])


def _needs(task: ArmTask, machine: Machine, moves: Moves) -> list[Need]:
    states = moves.states
    moving = np.abs(rigid_torques(machine, states, task.payload))
    still = states._replace(velocities=0.0 * states.velocities, accelerations=0.0 * states.accelerations)
    static = np.abs(rigid_torques(machine, still, task.payload))
    rows = moving.max(axis=0), static.max(axis=0), np.abs(states.velocities).max(axis=0)
    return [Need(*map(float, row)) for row in zip(*rows, strict=True)]


def _wanted(task: ArmTask, part: Part, need: Need) -> float:
    """Return the torque at supply pressure of a joint that gives what is needed, friction and losses besides, N m."""
    (joint,) = part.joint.machine.joints.values()
    left = USABLE * (1.0 - BRAKE_SHARE - 0.5 * float(loss_share(joint)))
    return task.margin * need.torque / left


def _with_valves(task: ArmTask, moves: Moves, parts: Sequence[Part], machine: Machine) -> tuple[Part, ...]:
    sold, sizes = sold_valves(machine), task.margin * valve_sizes(machine, moves, task.payload)
    return tuple(
        part._replace(valve=choose(sold, float(size), f"{task.origin}: joint {part.task.name!r}"))
        for part, size in zip(parts, sizes, strict=True)
    )
