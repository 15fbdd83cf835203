"""Every row of the table at random instants of random moves, and what came of each."""

from collections.abc import Iterator
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.rig.abilities import falls, payloads, resting_angles, sinks, swings_on, vent_time
from layflat.rig.clock import SECOND
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.driver import DeviceState
from layflat.rig.safety.limits import plans
from layflat.rig.safety.states import State
from layflat.rig.trials.cases import HOST_GONE, ROWS, FaultCase
from layflat.rig.trials.rig import TrialRig

SPAN = 0.5  # of the working stroke in which moves end: an arm that stops at once flings its elbow by half a stroke
PAUSE = (0.7, 2.0)  # between two demands, s
WHEN = (0.3, 2.0)  # after the first demand, in which the failure comes, s
ON_ITS_WAY = (0.06, 0.2)  # after the demand that sets a joint going, in which the failure comes, s
ARRIVES = 1.0  # after that instant, in which a joint that was to be on its way has arrived, s
GOING = 0.6  # speed that it has then at least, rad/s
GONE = (0.5, 2.0)  # for which a loop is stopped, s
PATIENCE = 1.0  # beyond the time in which a fault has to be found, until it counts as missed, s
SETTLES = 3.0  # in which what is safe has to be reached, s
HOME = 0.5  # rad: joints that are further from mid-stroke are led back after a trial
HAND = 2.0  # torque of that hand, as a multiple of what the brake holds


class Outcome(NamedTuple):
    """One trial."""

    row: str
    case: str
    joint: str
    at: float  # s after the first demand
    found_after: float  # s; infinite where it was missed
    limit: float  # s
    found: str  # which fault it was told as
    safe_after: float  # s after the failure; infinite where it was not reached
    safe: str  # what had to be reached
    turned: float  # the furthest that a joint was from mid-stroke, as a share of where its stops may hold it
    above_supply: float  # highest pressure in a hose less the highest that the supply line had, Pa
    pushed: bool  # whether somebody pushed the joint, or its valve did: into its stop, which alone could hold it
    swung: bool  # whether the arm was so fast by then, or sinks so far, that its stops alone could hold it

    @property
    def good(self) -> bool:
        """Whether it was found in time, and what is safe was reached."""
        return self.found_after <= self.limit + 1e-9 and self.safe_after < inf and self.kept

    @property
    def kept(self) -> bool:
        """Whether no joint passed its mechanical stroke that anything but its stop could have held."""
        return self.turned <= 1.0 or self.pushed or self.swung


def campaign(rig: TrialRig, instants: int = 20, seed: int = 0) -> Iterator[Outcome]:
    """Try each row so often, one trial after the other; the seed is that of moves, joints, ways and instants."""
    for i, (row, ways) in enumerate(ROWS.items()):
        for number in range(instants):
            yield Trial(rig, row, ways[number % len(ways)], np.random.default_rng((seed, i, number))).run()


def lead_home(device: VirtualDevice, home: float, sinking: NDArray[np.bool_]) -> bool:
    """Turn joints that are further than `home` (rad) from mid-stroke towards it; whether there are any.

    Those that sink stay where they are: a rig leads them itself, from their stops.
    """
    away = ~sinking & (np.abs(device.plant.angles) > home)
    for j, angle in enumerate(device.plant.angles):
        device.plant.load[j] = -np.sign(angle) * HAND * device.brakes[j] if away[j] else 0.0
    return bool(away.any())


def carry(device: VirtualDevice, payload: float) -> None:
    """Give the arm a payload (kg); called on the device."""
    device.plant.payload = payload


class Trial:
    """One failure of a rig that moves at random."""

    def __init__(self, rig: TrialRig, row: str, case: FaultCase, random: np.random.Generator) -> None:
        self.rig, self.row, self.case, self.random = rig, row, case, random
        self.joints = list(rig.machine.joints.values())
        self.joint = int(random.integers(len(self.joints)))
        self._reaches = [0.5 * SPAN * joint.stops.working_stroke for joint in self.joints]
        self._next = 0

    def run(self) -> Outcome:
        """Bring the air, move, fail, watch, mend."""
        rig, case = self.rig, self.case
        lightest, heaviest = payloads(rig.machine)
        if plans(rig.machine) and lightest < heaviest:
            rig.device.call(carry, float(self.random.uniform(lightest, heaviest)))
        rig.ready()
        rig.clear_peaks()
        begun = rig.clock.now()
        instant = self._until_failure(begun)
        if not self._obeys():
            found, by, limit = inf, f"stopped before it failed: {rig.supervisor.ledger.worst.title}", 0.0
        elif self.row == HOST_GONE:
            found, by, limit = self._host_gone()
        else:
            rig.clock.at(instant, lambda: case.switch(rig, self.joint, True))
            found, by, limit = self._found(instant)
        swung, sinking = self._swings_on(), sinks(rig.machine)
        safe = self._safe(instant)
        turned = np.array(rig.furthest) / resting_angles(rig.machine)
        swung = swung or bool(turned.max() > 1.0 and not (turned[~sinking] > 1.0).any())
        above_supply = rig.above_supply
        self._mend()
        return Outcome(
            self.row, case.name, list(rig.machine.joints)[self.joint], (instant - begun) / SECOND, found, limit, by,
            safe, case.safe.name, float(turned.max()), above_supply, case.pushed, swung,
        )  # fmt: skip

    # Before

    def _until_failure(self, begun: int) -> int:
        """Move at random up to the cycle in which it fails; the instant (ns)."""
        random, rig = self.random, self.rig
        when = begun + round(random.uniform(*WHEN) * SECOND)
        while self._obeys() and (rig.clock.now() < when or (self.case.moving and not self._off())):
            self._move()
            rig.cycle()
        if not self.case.moving:
            return rig.clock.now() + int(random.integers(1, round(rig.period * SECOND)))
        instant = rig.clock.now() + round(random.uniform(*ON_ITS_WAY) * SECOND)
        while self._obeys() and (rig.clock.now() + rig.period * SECOND < instant or not self._goes()):
            rig.cycle()
            if rig.clock.now() > instant + ARRIVES * SECOND:  # it has arrived before: once more
                while self._obeys() and not self._off():
                    self._move()
                    rig.cycle()
                instant = rig.clock.now() + round(random.uniform(*ON_ITS_WAY) * SECOND)
        return max(instant, rig.clock.now() + 1)

    def _obeys(self) -> bool:
        """Whether the rig moves as it is asked to: not where it was stopped for nothing, before anything failed."""
        return self.rig.supervisor.state in {State.READY, State.MOVING}

    def _move(self) -> None:
        """Ask for another place now and then."""
        now, rig = self.rig.clock.now(), self.rig
        if now >= self._next:
            self._next = now + round(self.random.uniform(*PAUSE) * SECOND)
            rig.host.demands = self._place()

    def _place(self) -> list[float]:
        return [float(self.random.uniform(-reach, reach)) for reach in self._reaches]

    def _off(self) -> bool:
        """Ask the joint to go far, in this cycle; False if it did not come to that."""
        here, demands = self.rig.truth.angles[self.joint], self._place()
        side = -1.0 if here > 0.0 else 1.0
        demands[self.joint] = float(self.random.uniform(0.0, self._reaches[self.joint])) * side
        if abs(demands[self.joint] - here) < self.case.way_to_go:
            return False
        self.rig.host.demands = demands
        self._next = self.rig.clock.now() + round(PAUSE[1] * SECOND)
        return True

    def _goes(self) -> bool:
        """Whether the joint is on its way, and has some of it left."""
        angle, velocity = self.rig.truth.angles[self.joint], self.rig.truth.velocities[self.joint]
        left = abs(self.rig.host.demands[self.joint] - angle)
        return abs(velocity) >= GOING and left >= self.case.way_left

    # After

    def _swings_on(self) -> bool:
        """Whether nothing but its stops may hold the arm from now on: brakes can where a rig leads it slowly."""
        core, truth = self.rig.supervisor.core, self.rig.truth
        torques = core.settings["torque_constant"] * core.memory["estimate.averaged_pressure"]
        return plans(self.rig.machine) and swings_on(self.rig.machine, truth.angles, truth.velocities, torques)

    def _found(self, instant: int) -> tuple[float, str, float]:
        """After how long the fault was found (s), as what, and in which time it had to be (s)."""
        rig, case = self.rig, self.case
        limit = case.cycles * rig.period if case.cycles else case.seconds
        since: int | None = None if case.since is not None else instant
        for _ in range(round((limit + PATIENCE) / rig.period)):
            self._move()
            if rig.clock.now() < instant:
                rig.recorder.lines.clear()
            rig.cycle()
            now = rig.clock.now()
            if case.since is not None:
                beyond = case.since(rig, self.joint)
                since = (since or now - round(rig.period * SECOND)) if beyond else None
            said = "\n".join(rig.recorder.lines)
            by = [fault for fault in case.found if fault.title in said]
            if by and now > instant:
                if case.brief:
                    case.switch(rig, self.joint, False)
                return (now - (since if since is not None else now)) / SECOND, by[0].title, limit
        return inf, "", limit

    def _host_gone(self) -> tuple[float, str, float]:
        """Stop the loop for a while: the device has to centre its valves, and to let out the air later."""
        rig, interface = self.rig, self.rig.machine.interface
        last = rig.clock.now()
        found, dumped, step = inf, inf, SECOND // 1000
        end = last + round(self.random.uniform(*GONE) * SECOND)
        while rig.clock.now() < end:
            rig.clock.wait(rig.clock.now() + step)
            rig.look()
            quiet = (rig.clock.now() - last) / SECOND
            if rig.truth.device is not DeviceState.RUNNING:
                found = min(found, quiet)
            if rig.truth.device is DeviceState.DUMPED:
                dumped = min(dumped, quiet)
        if dumped > interface.dump_after + 1e-3 + 1e-9:
            found = inf
        by = f"by the device: centred, dumped after {1e3 * dumped:.0f} ms"
        return found, by, interface.watchdog_cycles * rig.period + 1e-3

    def _safe(self, instant: int) -> float:
        """How long after the failure what is safe was reached, s."""
        rig = self.rig
        slowly = vent_time(rig.machine) if falls(rig.machine) else 0.0
        until = rig.clock.now() + round((SETTLES + slowly) * SECOND)
        while not self.case.safe.is_reached(rig, self.joint):
            if rig.clock.now() >= until:
                return inf
            rig.cycle()
        return (rig.clock.now() - instant) / SECOND

    def _mend(self) -> None:
        """Heal, stop, let the air out, and reset."""
        rig = self.rig
        self.case.switch(rig, self.joint, False)
        rig.host.edges = {"stop"}
        for _ in range(round((rig.machine.safety.hold_time + vent_time(rig.machine)) / rig.period)):
            rig.cycle()
        # By hand, as anyone would who finds a joint at its stop without air.
        while rig.device.call(lead_home, HOME, sinks(rig.machine)):
            rig.cycle()
        rig.host.edges = {"reset"}
        for _ in range(8):
            rig.cycle()


def judged(outcomes: list[Outcome]) -> dict[str, dict[str, float | int]]:
    """By row: trials, good ones, and the worst of what was measured."""
    rows: dict[str, dict[str, float | int]] = {}
    for row in dict.fromkeys(outcome.row for outcome in outcomes):
        own = [outcome for outcome in outcomes if outcome.row == row]
        worst = ("found_after", "limit", "safe_after", "turned", "above_supply")
        rows[row] = {"trials": len(own), "good": sum(outcome.good for outcome in own)}
        rows[row] |= {name: max(getattr(outcome, name) for outcome in own) for name in worst}
    return rows
