"""Campaign of trials: every row of the table of faults at random instants of random moves, with its outcome."""

from collections.abc import Iterator
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.rig.abilities import (
    falls_without_air,
    find_sinking_joints,
    may_reach_stops,
    payload_range,
    resting_angles,
    vent_time,
)
from layflat.rig.clock import NS_PER_SECOND
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.device_state import DeviceState
from layflat.rig.safety.faults import RigState
from layflat.rig.safety.limits import plans_motion
from layflat.rig.trials.cases import FAULT_CASES, HOST_GONE, FaultCase
from layflat.rig.trials.rig import TrialRig

STROKE_FRACTION = (
    0.5  # of the working stroke in which moves end: an arm that stops at once accelerates its elbow that far
)
PAUSE_RANGE = (0.7, 2.0)  # between two demands, s
FAILURE_TIME_RANGE = (0.3, 2.0)  # of the failure after the first demand, s
MOVING_TIME_RANGE = (0.06, 0.2)  # of the failure after the demand that starts a joint's motion, s
ARRIVAL_TIME = 1.0  # after that instant, at which a joint that should be moving has arrived, s
MIN_MOVING_SPEED = 0.6  # of a joint that is moving, rad/s
HOST_GONE_RANGE = (0.5, 2.0)  # for which a loop is stopped, s
MISSED_AFTER = 1.0  # after the limit of the detection time, at which a fault counts as missed, s
SETTLING_TIME = 3.0  # within which the safe state has to be reached, s
HOME_ANGLE = 0.5  # angle from mid-stroke beyond which joints are pushed back after a trial, rad
HAND_TORQUE_RATIO = 2.0  # torque of that push over the holding torque of the brake


class TrialOutcome(NamedTuple):
    """Outcome of one trial."""

    row: str  # of the table of faults
    case: str  # name of the case
    joint: str
    at: float  # instant of the failure after the first demand, s
    detection_time: float  # detection time, s; infinite where it was missed
    limit: float  # of the detection time, s
    detected: str  # title of the fault that was detected
    safe_after: float  # time from the failure to the safe state, s; infinite where it was not reached
    safe: str  # name of the required safe state
    turned: float  # greatest angle of a joint from mid-stroke over that at which its stops may hold it
    above_supply: float  # highest pressure in a hose less the highest of the supply line, Pa
    pushed: bool  # whether a hand or the valve pushed the joint into its stop, which alone could hold it
    swung: bool  # whether the arm was so fast at the detection, or sinks so far, that its stops alone could hold it

    @property
    def is_good(self) -> bool:
        """Return whether the fault was detected in time, a safe state was reached, and the joints stayed in strokes."""
        return self.detection_time <= self.limit + 1e-9 and self.safe_after < inf and self.is_within_strokes

    @property
    def is_within_strokes(self) -> bool:
        """Return whether no joint passed its mechanical stroke, except those that its stop alone could have held."""
        return self.turned <= 1.0 or self.pushed or self.swung


def run_campaign(rig: TrialRig, instants: int = 20, seed: int = 0) -> Iterator[TrialOutcome]:
    """Yield the outcomes of trials of all rows, one after the other.

    Args:
        rig: rig of the trials.
        instants: number of trials of each row, over its cases in turn.
        seed: seed of moves, joints and instants.
    """
    for i, (row, ways) in enumerate(FAULT_CASES.items()):
        for number in range(instants):
            yield FaultTrial(rig, row, ways[number % len(ways)], np.random.default_rng((seed, i, number))).run()


def push_home(device: VirtualDevice, home: float, sinking: NDArray[np.bool_]) -> bool:
    """Push joints that are far from mid-stroke towards it, let go of all others, and return whether any is pushed.

    Called on the device.

    Args:
        device: the device.
        home: angle from mid-stroke beyond which a joint is pushed, rad.
        sinking: mask of joints that sink, (joints,); they stay: the rig itself moves them from their stops.
    """
    away = ~sinking & (np.abs(device.plant.angles) > home)
    for j, angle in enumerate(device.plant.angles):
        device.plant.load[j] = -np.sign(angle) * HAND_TORQUE_RATIO * device.brakes[j] if away[j] else 0.0
    return bool(away.any())


def set_payload(device: VirtualDevice, payload: float) -> None:
    """Set the payload of the arm (kg); called on the device."""
    device.plant.payload = payload


class FaultTrial:
    """Trial of one failure of a rig that moves at random."""

    def __init__(self, rig: TrialRig, row: str, case: FaultCase, random: np.random.Generator) -> None:
        self.rig, self.row, self.case, self.random = rig, row, case, random
        self.joints = list(rig.machine.joints.values())
        self.joint = int(random.integers(len(self.joints)))
        self._reaches = [0.5 * STROKE_FRACTION * joint.stops.working_stroke for joint in self.joints]
        self._next = 0

    def run(self) -> TrialOutcome:
        """Start, move, inject the failure, measure detection and reaction, and heal; return the outcome."""
        rig, case = self.rig, self.case
        lightest, heaviest = payload_range(rig.machine)
        if plans_motion(rig.machine) and lightest < heaviest:
            rig.device.call(set_payload, float(self.random.uniform(lightest, heaviest)))
        rig.ready()
        rig.clear_peaks()
        begun = rig.clock.now()
        instant = self._until_failure(begun)
        if not self._accepts_demands():
            delay, by, limit = inf, f"stopped before it failed: {rig.supervisor.ledger.worst.title}", 0.0
        elif self.row == HOST_GONE:
            delay, by, limit = self._stop_host()
        else:
            rig.clock.schedule(instant, lambda: case.switch(rig, self.joint, True))
            delay, by, limit = self._measure_detection(instant)
        swung, sinking = self._may_reach_stops(), find_sinking_joints(rig.machine)
        safe = self._time_to_safe_state(instant)
        turned = np.array(rig.furthest) / resting_angles(rig.machine)
        swung = swung or bool(turned.max() > 1.0 and not (turned[~sinking] > 1.0).any())
        above_supply = rig.above_supply
        self._mend()
        return TrialOutcome(
            self.row, case.name, list(rig.machine.joints)[self.joint], (instant - begun) / NS_PER_SECOND, delay, limit,
            by, safe, case.safe.name, float(turned.max()), above_supply, case.pushed, swung,
        )  # fmt: skip

    # Before

    def _until_failure(self, begun: int) -> int:
        """Move at random up to the cycle of the failure, and return its instant, ns.

        For a case with `moving` the joint is in a long motion then. It ends early if the rig no longer accepts demands.
        """
        random, rig = self.random, self.rig
        when = begun + round(random.uniform(*FAILURE_TIME_RANGE) * NS_PER_SECOND)
        while self._accepts_demands() and (
            rig.clock.now() < when or (self.case.moving and not self._start_long_motion())
        ):
            self._move()
            rig.cycle()
        if not self.case.moving:
            return rig.clock.now() + int(random.integers(1, round(rig.period * NS_PER_SECOND)))
        instant = rig.clock.now() + round(random.uniform(*MOVING_TIME_RANGE) * NS_PER_SECOND)
        while self._accepts_demands() and (
            rig.clock.now() + rig.period * NS_PER_SECOND < instant or not self._is_moving()
        ):
            rig.cycle()
            if rig.clock.now() > instant + ARRIVAL_TIME * NS_PER_SECOND:  # it arrived too soon: try again
                while self._accepts_demands() and not self._start_long_motion():
                    self._move()
                    rig.cycle()
                instant = rig.clock.now() + round(random.uniform(*MOVING_TIME_RANGE) * NS_PER_SECOND)
        return max(instant, rig.clock.now() + 1)

    def _accepts_demands(self) -> bool:
        """Return whether the rig accepts demands: it does not after a false alarm before the failure."""
        return self.rig.supervisor.state in {RigState.READY, RigState.MOVING}

    def _move(self) -> None:
        """Demand another configuration now and then."""
        now, rig = self.rig.clock.now(), self.rig
        if now >= self._next:
            self._next = now + round(self.random.uniform(*PAUSE_RANGE) * NS_PER_SECOND)
            rig.host.demands = self._random_demands()

    def _random_demands(self) -> list[float]:
        """Return an angle for each joint, rad, uniform in `STROKE_FRACTION` of its working stroke."""
        return [float(self.random.uniform(-reach, reach)) for reach in self._reaches]

    def _start_long_motion(self) -> bool:
        """Demand a long motion of the joint in this cycle; return False if the random demand was too near."""
        here, demands = self.rig.truth.angles[self.joint], self._random_demands()
        side = -1.0 if here > 0.0 else 1.0
        demands[self.joint] = float(self.random.uniform(0.0, self._reaches[self.joint])) * side
        if abs(demands[self.joint] - here) < self.case.min_motion:
            return False
        self.rig.host.demands = demands
        self._next = self.rig.clock.now() + round(PAUSE_RANGE[1] * NS_PER_SECOND)
        return True

    def _is_moving(self) -> bool:
        """Return whether the joint truly is no slower than `MIN_MOVING_SPEED`, and still far from its demand.

        That is at least `case.min_remaining`, rad.
        """
        angle, velocity = self.rig.truth.angles[self.joint], self.rig.truth.velocities[self.joint]
        remaining = abs(self.rig.host.demands[self.joint] - angle)
        return abs(velocity) >= MIN_MOVING_SPEED and remaining >= self.case.min_remaining

    # After

    def _may_reach_stops(self) -> bool:
        """Return whether nothing but its stops may hold the arm from now on; False under a law that plans no motion."""
        core, truth = self.rig.supervisor.core, self.rig.truth
        torques = core.settings["torque_constant"] * core.memory["estimate.averaged_pressure"]
        return plans_motion(self.rig.machine) and may_reach_stops(
            self.rig.machine, truth.angles, truth.velocities, torques
        )

    def _measure_detection(self, instant: int) -> tuple[float, str, float]:
        """Run cycles until the fault is detected or missed.

        Returns:
            Detection time, s, from `instant` or as `FaultCase.since` tells; title of the fault; limit of the time, s. A
            missed one has an infinite time and an empty title.
        """
        rig, case = self.rig, self.case
        limit = case.cycles * rig.period if case.cycles else case.seconds
        since: int | None = None if case.since is not None else instant
        for _ in range(round((limit + MISSED_AFTER) / rig.period)):
            self._move()
            if rig.clock.now() < instant:
                rig.recorder.lines.clear()
            rig.cycle()
            now = rig.clock.now()
            if case.since is not None:
                beyond = case.since(rig, self.joint)
                since = (since or now - round(rig.period * NS_PER_SECOND)) if beyond else None
            events = "\n".join(rig.recorder.lines)
            by = [fault for fault in case.detectable_as if fault.title in events]
            if by and now > instant:
                if case.brief:
                    case.switch(rig, self.joint, False)
                return (now - (since if since is not None else now)) / NS_PER_SECOND, by[0].title, limit
        return inf, "", limit

    def _stop_host(self) -> tuple[float, str, float]:
        """Stop the loop for a while, in which the device has to centre its valves and, later, to vent the supply line.

        Returns:
            Time from the loop's last cycle until the device centres its valves, s (inf if it does not, or dumps too
            late); description of its reaction; limit by the watchdog, s.
        """
        rig, interface = self.rig, self.rig.machine.interface
        last = rig.clock.now()
        centred, dumped, step = inf, inf, NS_PER_SECOND // 1000
        end = last + round(self.random.uniform(*HOST_GONE_RANGE) * NS_PER_SECOND)
        while rig.clock.now() < end:
            rig.clock.wait(rig.clock.now() + step)
            rig.update_peaks()
            quiet = (rig.clock.now() - last) / NS_PER_SECOND
            if rig.truth.device is not DeviceState.RUNNING:
                centred = min(centred, quiet)
            if rig.truth.device is DeviceState.DUMPED:
                dumped = min(dumped, quiet)
        if dumped > interface.dump_after + 1e-3 + 1e-9:
            centred = inf
        by = f"by the device: centred, dumped after {1e3 * dumped:.0f} ms"
        return centred, by, interface.watchdog_cycles * rig.period + 1e-3

    def _time_to_safe_state(self, instant: int) -> float:
        """Run cycles until a safe state is reached; return its time since the failure, s, infinite if too late."""
        rig = self.rig
        slowly = vent_time(rig.machine) if falls_without_air(rig.machine) else 0.0
        until = rig.clock.now() + round((SETTLING_TIME + slowly) * NS_PER_SECOND)
        while not self.case.safe.is_reached(rig, self.joint):
            if rig.clock.now() >= until:
                return inf
            rig.cycle()
        return (rig.clock.now() - instant) / NS_PER_SECOND

    def _mend(self) -> None:
        """Heal the failure, stop, vent, push joints back towards mid-stroke, and reset."""
        rig = self.rig
        self.case.switch(rig, self.joint, False)
        rig.host.edges = {"stop"}
        for _ in range(round((rig.machine.safety.hold_time + vent_time(rig.machine)) / rig.period)):
            rig.cycle()
        # By hand, as an operator would move a joint from its stop without air.
        while rig.device.call(push_home, HOME_ANGLE, find_sinking_joints(rig.machine)):
            rig.cycle()
        rig.host.edges = {"reset"}
        for _ in range(8):
            rig.cycle()


def summarize_outcomes(outcomes: list[TrialOutcome]) -> dict[str, dict[str, float | int]]:
    """Return a table by row: `trials` and `good` (counts), and maxima over the row's trials.

    The maxima are `detection_time`, `limit`, `safe_after`, `turned` and `above_supply`, as of `TrialOutcome`.
    """
    rows: dict[str, dict[str, float | int]] = {}
    for row in dict.fromkeys(outcome.row for outcome in outcomes):
        of_row = [outcome for outcome in outcomes if outcome.row == row]
        worst = ("detection_time", "limit", "safe_after", "turned", "above_supply")
        rows[row] = {"trials": len(of_row), "good": sum(outcome.is_good for outcome in of_row)}
        rows[row] |= {name: max(getattr(outcome, name) for outcome in of_row) for name in worst}
    return rows
