"""The simulated arm with its controllers under the state machine of picks; a lift and a cup by their limits alone."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from layflat.cell.plan.pick import CellReadings, PickCommand, PickPhase, PickRules, PickState, PickTask
from layflat.cell.plan.pick_machine import begin_pick, step_pick
from layflat.machine import Machine, parameters
from layflat.motion.limits import MotionLimits
from layflat.motion.planar import PlanarReach
from layflat.motion.travel import DEMAND_LEAD, PlannedMove, plan_move, plan_travel
from layflat.sim.plant import SteppedPlant
from tests.physics.controllers import Controller

Array = NDArray[np.float64]

CYCLE = 0.005
LIFT = MotionLimits((0.8,), (8.0,), (400.0,))
VACUUM, TIME_CONSTANT = 50e3, 0.04
"""In the cup on a fruit (Pa), and with which it comes and goes (s)."""


@dataclass
class Picked:
    """What became of a pick: s, m, and the phases with the time that each began."""

    state: PickState
    time: float
    error: float
    began: list[tuple[PickPhase, float]] = field(default_factory=list)


class Bench:
    """An arm at rest at `start` that picks.

    Args:
        machine: with controller.
        start: rad, (joints,).
        seed: of the sensors' noise.
    """

    def __init__(self, machine: Machine, start: Array, seed: int = 0) -> None:
        self.machine, self.reach = machine, PlanarReach(machine)
        self.rules = PickRules(tip=self.reach.tip, clear=(0.9, 0.5))
        self.plant = SteppedPlant(machine, start=start.tolist(), seed=seed, payload=1.2)
        self.controller = Controller(parameters.control(machine), *self.plant.sense())
        self.demands = start.copy()
        self.rows: list[Array] = []
        self.height, self.lift_speed, self.vacuum, self.cycles = 0.15, 0.0, 0.0, 0
        self.sealed, self.fruit_height = False, 0.0
        self.lift: tuple[PlannedMove, int] | None = None
        self.target: tuple[float, ...] = tuple(start.tolist())

    def pick(self, task: PickTask) -> Picked:
        """One pick, from where the arm is."""
        self.fruit_height = task.fruit_height
        self.turn(None)
        state = begin_pick(task, self.measure())
        began, since, error = [(state.phase, 0.0)], self.cycles, np.inf
        while state.phase is not PickPhase.DONE:
            state, command = step_pick(self.rules, state, self.measure())
            if state.phase is not began[-1][0]:
                began.append((state.phase, CYCLE * (self.cycles - since)))
                if state.phase is PickPhase.RELEASE:
                    true, wanted = self.reach.tip(tuple(self.plant.angles.tolist())), self.reach.tip(task.over_place)
                    error = float(np.hypot(true[0] - wanted[0], true[1] - wanted[1]))
            self.turn(command)
        return Picked(state, CYCLE * (self.cycles - since), error, began)

    def measure(self) -> CellReadings:
        """As the controllers and switches tell."""
        report = self.controller.report
        angles = tuple(float(joint.averaged_angle) for joint in report) or (0.0,) * len(self.demands)
        velocities = tuple(float(joint.averaged_velocity) for joint in report) or (0.0,) * len(self.demands)
        return CellReadings(CYCLE * self.cycles, angles, velocities, self.vacuum, self.height, self.lift_speed)

    def turn(self, command: PickCommand | None) -> None:
        """One control cycle."""
        if command is not None:
            self._plan(command)
        if self.rows:
            self.demands = self.rows.pop(0)
        angles, pressures = self.plant.sense()
        self.plant.drive(self.controller.voltages(angles, pressures, CYCLE, self.demands))
        self.cycles += 1
        self.plant.advance(CYCLE * self.cycles + 1e-9)

    def _plan(self, command: PickCommand) -> None:
        if command.target != self.target:
            path = plan_move(self.machine, self.demands, np.array(command.target), payload=1.2)
            self.rows, self.target = list(path.demand(CYCLE, lead=DEMAND_LEAD)), command.target
        if self.lift is None or command.height != self.lift[0].end[0]:
            self.lift = plan_travel(np.array([self.height]), np.array([command.height]), LIFT), self.cycles
        path, begun_at = self.lift
        at = [CYCLE * (self.cycles + 1 - begun_at)]
        self.height, self.lift_speed = float(path.angles_at(at)[0, 0]), float(path.states(at).velocities[0, 0])
        self.sealed = command.suction and (self.sealed or self.height <= self.fruit_height + 1e-9)
        self.vacuum += CYCLE / TIME_CONSTANT * ((VACUUM if self.sealed else 0.0) - self.vacuum)
