"""Packing from trays: observe, choose, pick, observe again on release, until nothing is left to pick.

Heights of the lift follow from the cell's description and the fruit's diameter.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import cos, dist, sin

from layflat.cell.file.model import Cell
from layflat.cell.perception import Observation, Perception
from layflat.cell.plan.order import (
    ContainerPlace,
    Fruit,
    NotPicked,
    PickChoice,
    choose_pick,
    empty_packing,
    free_place_at,
)
from layflat.cell.plan.pick import (
    CellReadings,
    PickCommand,
    PickOutcome,
    PickPhase,
    PickRules,
    PickState,
    PickTask,
    Relocation,
)
from layflat.cell.plan.pick_machine import begin_pick, step_pick
from layflat.cell.vision import SURE_CONFIDENCE
from layflat.cell.work.observer import Observer, Pick
from layflat.cell.work.station import CellStation
from layflat.cell.work.world_model import WorldModel, fruit_distance, is_same_fruit
from layflat.motion.planar import Angles, PlanarReach

PASSING_CLEARANCE = 10e-3  # of moving parts over the obstacles below, m
PRESSING_DEPTH = 3e-3  # of the cup's demand below the estimated top of a fruit, m; the lift is compliant
SEALING_TIME = 0.25  # of settling and build-up of the vacuum, s
RELEASE_HEIGHT = 2e-3  # of a fruit over the floor of its place, m
MAX_IMAGES, IMAGE_PAUSE = (
    3,
    0.2,
)  # that are tried one after the other until one can be used, and the time between them, s
MAX_STRAY = 30e-3  # distance by which a missed fruit may have rolled and is still identified as the same, m
OUTSIDE_REASON = "lies beside trays and containers"


def passing_height(cell: Cell) -> float:
    """Return the height of the cup's lip at which an empty cup clears everything, m; at most that of the lift."""
    return min(cell.obstacle_height + PASSING_CLEARANCE, cell.lift.clearance)


def plan_task(cell: Cell, choice: PickChoice) -> PickTask:
    """Return the task of a chosen pick: heights follow from the flattening of its kind, as far as the lift reaches."""
    flattening, passing = cell.produce[choice.fruit.kind].flattening, passing_height(cell)
    height = flattening.mean * choice.fruit.diameter
    min_height, max_height = flattening.min * choice.fruit.diameter, flattening.max * choice.fruit.diameter
    floor = cell.floor_at(choice.fruit.x, choice.fruit.y)
    return PickTask(
        choice.over_fruit.angles,
        choice.over_place.angles,
        fruit_height=floor + height - PRESSING_DEPTH,
        lowest=floor + min_height - PRESSING_DEPTH,
        place_height=choice.place.z + height - PRESSING_DEPTH + RELEASE_HEIGHT,
        passing=passing,
        carrying=min(passing + max_height, cell.lift.clearance),
    )


def handling_time(cell: Cell, fruit: Fruit) -> float:
    """Return the time for which the arm has to stay over a fruit until the cup holds it, s."""
    lift, top = cell.lift, cell.floor_at(fruit.x, fruit.y) + cell.produce[fruit.kind].flattening.mean * fruit.diameter
    return (passing_height(cell) - top) / lift.speed + lift.speed / lift.acceleration + SEALING_TIME


def centre_fruit(task: PickTask, fruit: Fruit, place: ContainerPlace, at: Angles, reach: PlanarReach) -> PickTask:
    """Return the task with the fruit's middle, not the cup's, over the middle of its place.

    The cup sits off the fruit's middle by the arm's position error; that offset rotates with the last link.
    Where the arm can't reach, the task is unchanged.

    Args:
        task: task of the pick.
        fruit: fruit on the cup, with the position of its middle.
        place: place in which it is to lie.
        at: joint angles with the cup on the fruit, rad.
        reach: inverse kinematics of the arm.
    """
    (x, y), rotation = reach.tip(at), sum(task.over_place) - sum(at)
    right, ahead = fruit.x - x, fruit.y - y
    c, s = cos(rotation), sin(rotation)
    tip = place.x - (c * right - s * ahead), place.y - (s * right + c * ahead)
    nearest = min(
        reach.configurations(*tip), key=lambda configuration: dist(configuration.angles, task.over_place), default=None
    )
    return replace(task, over_place=nearest.angles) if nearest is not None else task


def pick_rules(cell: Cell, reach: PlanarReach) -> PickRules:
    """Return the rules of picks in a cell, with vacuums by the cup's time constants."""
    # Steady-state vacuums with the ejector on, Pa: of a cup on a fruit, and of an open one.
    cup = cell.cup
    closed, opened = (cup.vacuum / (1.0 + cup.build_up / leak) for leak in (cup.leak, cup.open_leak))
    return PickRules(
        tip=reach.tip,
        clear=tuple(cell.mount.home[name] for name in cell.machine.joints),
        sound=opened + 0.6 * (closed - opened),
        lost_vacuum=opened + 0.3 * (closed - opened),
        empty=0.02 * closed,
    )


class Packer:
    """Packer of a cell with trays: decides by the station's sensors and the perception's images alone."""

    def __init__(self, cell: Cell, station: CellStation, perception: Perception, observer: Observer) -> None:
        """Begin with empty containers, and without an image."""
        self._cell, self._station, self._observer = cell, station, observer
        self._reach = PlanarReach(cell.machine)
        self._world = WorldModel(cell, perception, self._reach, observer)
        self._rules, self._passing = pick_rules(cell, self._reach), passing_height(cell)
        self.packing = empty_packing(cell)  # with the present contents of the containers
        self.not_picked: tuple[NotPicked, ...] = ()  # at the last choice
        self._given_up: list[Fruit] = []
        self._current = False  # True if the last image showed everything, and nothing has moved since

    def work(self, max_picks: int) -> Iterator[Pick]:
        """Yield one pick after the other, until `max_picks`, nothing can be picked, or a pick ends STUCK.

        Raises PictureError where the camera gives no image that can be used, RigStoppedError as the station.
        """
        self._observe_from_home()
        for number in range(1, max_picks + 1):
            choice = self._choose()
            if choice is None and not self._current:
                self._observe_from_home()
                choice = self._choose()
            if choice is None:
                return
            pick = self._pick(number, choice)
            yield pick
            if pick.outcome is PickOutcome.STUCK:
                return
            if pick.outcome is PickOutcome.LOST:
                self._observe_from_home()  # it may lie anywhere

    def finish(self) -> None:
        """Move the arm out of view and take a last image; an arm that holds something stays where it is."""
        if self._station.measure().vacuum < self._rules.lost_vacuum:
            self._observe_from_home()

    def _choose(self, only: Fruit | None = None) -> PickChoice | None:
        """Return the next pick of all fruit in trays, or of one of it; None if there is none.

        For all fruit, set `not_picked` with the reasons against the rest. Travel is the largest turn of a joint, rad.
        """
        fruits = self._world.in_trays
        tried = {fruit for fruit in fruits if any(is_same_fruit(fruit, other) for other in self._given_up)}
        passed = tried if only is None else set(fruits) - {only}
        selection = choose_pick(
            fruits, self.packing, self._reach, self._station.arm.angles, self._cell.cup.diameter / 2,
            lambda start, end: max(abs(a - b) for a, b in zip(start, end, strict=True)),
            least_confidence=SURE_CONFIDENCE, given_up=frozenset(passed),
        )  # fmt: skip
        if only is None:
            self.not_picked = selection.not_picked + tuple(
                NotPicked(outside, OUTSIDE_REASON) for outside in self._world.outside
            )
        return selection.choice

    def _pick(self, number: int, choice: PickChoice) -> Pick:
        """Perform a pick to its end, with a new choice on each image of the fruit, and return its result.

        A placed fruit is entered in `packing`; one that was missed, or stuck, is given up.
        """
        station, (observation, lay) = self._station, self._sighting(choice)
        self._observer.on_pick_start(lay, observation)
        start_time, air, self._current = station.time, station.air, False
        state, relocation = begin_pick(plan_task(self._cell, choice), self._measure()), None
        while state.phase is not PickPhase.DONE:
            before = state
            state, command = step_pick(self._rules, before, self._measure(relocation))
            relocation = None
            if state.phase is not before.phase:
                self._observer.on_phase_change(choice, before, state)
                state = self._follow(choice, before, state)
            if command.image and self._world.try_update(station.time, arm=None):
                again = self._choose_again(choice.fruit)
                choice = again or choice
                relocation = Relocation(plan_task(self._cell, again) if again else None)
            self._perform(command)
        assert state.outcome is not None  # it has ended
        if state.outcome is PickOutcome.PLACED:
            self.packing = self.packing.filled(choice.place, choice.fruit)
        elif state.outcome in {PickOutcome.MISSED, PickOutcome.STUCK}:
            self._given_up.append(choice.fruit)
        consumed = station.air - air
        return Pick(
            number, choice, state.outcome, state.trouble, state.tried, start_time, station.time, consumed, observation
        )

    def _sighting(self, choice: PickChoice) -> tuple[Observation, Fruit]:
        """Return the last observation of the chosen fruit, and the fruit as it was detected there."""
        return self._world.seen_in[choice.fruit], choice.fruit

    def _measure(self, relocation: Relocation | None = None) -> CellReadings:
        """Return the sensor readings, and the estimate of the picked fruit's motion."""
        return self._station.measure(relocation)

    def _perform(self, command: PickCommand) -> None:
        """Advance the station by a control cycle."""
        self._station.advance(command)

    def _follow(self, choice: PickChoice, before: PickState, after: PickState) -> PickState:
        """Return the state after a change of phase: a sealed fruit corrects the task, a carried one is forgotten.

        On release an image is taken, if it can be used.
        """
        angles = self._station.arm.angles
        match before.phase, after.phase:
            case PickPhase.SEAL, PickPhase.LIFT:
                return replace(after, task=centre_fruit(after.task, choice.fruit, choice.place, angles, self._reach))
            case PickPhase.LIFT, PickPhase.CARRY:
                self._world.forget(choice.fruit)
            case PickPhase.RELEASE, PickPhase.RAISE:
                self._world.try_update(self._station.time, angles)
        return after

    def _choose_again(self, fruit: Fruit) -> PickChoice | None:
        """Return the pick of a missed fruit at its present position; None if it is gone or can't be picked any more."""
        candidates = [
            new for new in self._world.in_trays if new.kind == fruit.kind and fruit_distance(new, fruit) < MAX_STRAY
        ]
        nearest = min(candidates, key=lambda new: fruit_distance(new, fruit), default=None)
        return self._choose(nearest) if nearest is not None else None

    def _observe_from_home(self) -> None:
        """Take an image with the arm out of view, and enter fruit in places in `packing`.

        An arm that does not get there in time counts as hiding fruit.
        Raise PictureError if none of `MAX_IMAGES` can be used.
        """
        arm = None if self._try_move_home() else self._station.arm.angles
        for _ in range(MAX_IMAGES - 1):
            if self._world.try_update(self._station.time, arm):
                break
            until = self._station.time + IMAGE_PAUSE
            while self._station.time < until:
                self._advance(self._rules.clear)
        else:
            self._world.update(self._station.time, arm)
        self._current = True
        for fruit in self._world.known:
            place = free_place_at(self._cell, self.packing, fruit)
            if place is not None and fruit.confidence >= SURE_CONFIDENCE:
                self.packing = self.packing.filled(place, fruit)

    def _try_move_home(self) -> bool:
        """Move the empty arm, suction off, out of the camera's view; return whether it arrived in `settle_time`."""
        rules, station = self._rules, self._station
        deadline = station.time + rules.settle_time
        while station.time < deadline:
            measured = station.measure()
            arrived = dist(rules.tip(measured.angles), rules.tip(rules.clear)) <= rules.off
            if arrived and all(abs(v) <= rules.still for v in measured.velocities):
                return True
            up = measured.height >= self._passing - rules.height
            self._advance(rules.clear if up else station.arm.target)
        return False

    def _advance(self, angles: Angles) -> None:
        """Advance by a control cycle between picks, towards joint angles."""
        self._perform(PickCommand(angles, self._passing, suction=False, image=False))
