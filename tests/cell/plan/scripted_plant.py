"""An arm, a lift and a cup by rule of thumb, for picks."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import hypot

from layflat.cell.plan.pick import CellReadings, PickCommand, PickPhase, PickRules, PickState, PickTask, Relocation
from layflat.cell.plan.pick_machine import begin_pick, step_pick
from layflat.machine import load
from layflat.motion.planar import PlanarReach

CYCLE = 0.005
REACH = PlanarReach(load("paper-arm-fast"))


def _tip(angles: tuple[float, ...]) -> tuple[float, float]:
    return REACH.tip(angles)


PASSING, CARRYING = 0.1, 0.16
RULES = PickRules(tip=_tip, clear=(0.9, 0.5))
_DOWN = RULES.lower_time + RULES.seal_time + RULES.heavy_time + RULES.lower_time + RULES.release_time
_TRY = RULES.settle_time + _DOWN + RULES.raise_time + RULES.settle_time + RULES.image_time
_CARRIED = RULES.settle_time + RULES.lower_time + RULES.raise_time
LONGEST = RULES.tries * (_TRY + _CARRIED) + RULES.release_time + RULES.raise_time
"""No pick may take longer, s."""
TASK = PickTask((0.1, 0.2), (-0.5, 0.4), 0.06, 0.054, 0.05, PASSING, CARRYING)


@dataclass
class Plant:
    """Joints go at 2 rad/s, the lift at 0.5 m/s, and the vacuum comes and goes in some cycles.

    Args:
        fruit: where fruit lies, with how sound a vacuum it gives (Pa).
        relocations: answers to pictures, in order.
        drops_at: phase in which what is held falls off.
        lift_speed: with something on the cup, m/s.
        leaves: whether the vacuum goes when suction is off.
        top: of the fruit, where the cup meets it, m.
    """

    fruit: dict[tuple[float, ...], float] = field(default_factory=lambda: {TASK.over_fruit: 50e3})
    relocations: list[Relocation] = field(default_factory=list)
    drops_at: PickPhase | None = None
    lift_speed: float = 0.5
    leaves: bool = True
    top: float = TASK.fruit_height
    angles: tuple[float, ...] = (0.0, 0.0)
    velocities: tuple[float, ...] = (0.0, 0.0)
    height: float = PASSING
    lift_moves: float = 0.0
    vacuum: float = 0.0
    time: float = 0.0
    held: float = 0.0
    laid: list[tuple[float, ...]] = field(default_factory=list)

    def measure(self, *, image: bool) -> CellReadings:
        found = self.relocations.pop(0) if image and self.relocations else None
        return CellReadings(self.time, self.angles, self.velocities, self.vacuum, self.height, self.lift_moves, found)

    def turn(self, command: PickCommand, state: PickState) -> None:
        self.time += CYCLE
        way = 2.0 * CYCLE
        after = tuple(q + min(max(d - q, -way), way) for q, d in zip(self.angles, command.target, strict=True))
        self.velocities = tuple((b - a) / CYCLE for a, b in zip(self.angles, after, strict=True))
        self.angles, before = after, self.height
        speed = CYCLE * (self.lift_speed if self.held else 0.5)
        self.height += min(max(command.height - self.height, -speed), speed)
        if state.phase_angles == TASK.over_fruit:
            self.height = max(self.height, self.top)
        self.lift_moves = (self.height - before) / CYCLE
        if state.phase is self.drops_at:
            self.held = 0.0
        if not command.suction and self.held and self.leaves:
            self.laid.append(self.angles)
            self.held = 0.0
        if command.suction and self.height <= self.top + 1e-9 and not self.held:
            self.held = self._under()
        goal = self.held if command.suction or not self.leaves else 0.0
        self.vacuum += 0.2 * (goal - self.vacuum)

    def _under(self) -> float:
        x, y = RULES.tip(self.angles)
        near = [p for p in self.fruit if hypot(RULES.tip(p)[0] - x, RULES.tip(p)[1] - y) < 5e-3]
        return self.fruit[near[0]] if near else 0.0


def run(plant: Plant, task: PickTask = TASK) -> tuple[PickState, list[tuple[PickState, PickCommand]]]:
    """A whole pick, and all that was asked for on its way."""
    measured = plant.measure(image=False)
    state, trace = begin_pick(task, measured), []
    while state.phase is not PickPhase.DONE:
        state, command = step_pick(RULES, state, measured)
        trace.append((state, command))
        plant.turn(command, state)
        measured = plant.measure(image=command.image)
        assert plant.time < LONGEST + 1.0
    return state, trace


def phases(trace: list[tuple[PickState, PickCommand]]) -> list[PickPhase]:
    """Each phase as it was entered."""
    found: list[PickPhase] = []
    for state, _ in trace:
        if not found or found[-1] is not state.phase:
            found.append(state.phase)
    return found
