"""Every row of the table at random instants of random moves, and what came of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np

from layflat.rig.clock import SECOND
from layflat.rig.driver import FarState
from layflat.rig.far.device import Device
from layflat.rig.safety.faults import TABLE, Fault
from layflat.rig.trials.stand import Stand
from layflat.rig.trials.table import ROWS, Safe, Way

SPAN = 0.5
"""Of the working stroke in which moves end: an arm that stops at once flings its elbow by half a stroke."""

PAUSE = (0.7, 2.0)
"""Between two demands, s."""

WHEN = (0.3, 2.0)
"""After the first demand, in which the failure comes, s."""

ON_ITS_WAY = (0.06, 0.2)
"""After the demand that sets a joint going, in which the failure comes, s."""

GOING = 0.6
"""Speed that it has then at least, rad/s."""

PATIENCE = 1.0
"""Beyond the time in which a fault has to be found, until it counts as missed, s."""

SETTLES = 3.0
"""In which what is safe has to be reached, s."""

HOME = 0.5
"""rad: joints that are further from mid-stroke are led back after a trial."""

HAND = 2.0
"""Torque of that hand, as a multiple of what the brake holds."""

EMPTY = 0.3e5
"""Gauge pressure below which a hose is empty, Pa."""

STILL = 0.02
"""Speed below which a joint stands still, rad/s."""

HOST_GONE = "host dead, frozen or late"
LATE = Way(
    "late host", lambda *_: None, lambda *_: None, (Fault.FAR_CENTRED, Fault.FAR_DUMPED), Safe.ALL_VENTED, cycles=4
)


class Outcome(NamedTuple):
    """One trial."""

    row: str
    way: str
    joint: str
    at: float
    """s after the first demand."""
    found_after: float
    """s; infinite where it was missed."""
    limit: float
    """s"""
    found: str
    """Which fault it was told as."""
    safe_after: float
    """s after the failure; infinite where it was not reached."""
    safe: str
    """What had to be reached."""
    turned: float
    """The furthest that a joint was from mid-stroke, as a share of half its mechanical stroke."""
    above_supply: float
    """Highest pressure in a hose less the highest that the supply line had, Pa."""
    pushed: bool
    """Whether somebody pushed the joint, or its valve did: into its stop, which alone could hold it."""

    @property
    def good(self) -> bool:
        """Whether it was found in time, and what is safe was reached."""
        return self.found_after <= self.limit + 1e-9 and self.safe_after < inf and (self.turned <= 1.0 or self.pushed)


@dataclass(frozen=True)
class Campaign:
    """Trials of all rows on one stand.

    Args:
        stand: rig and loop.
        instants: trials of each row.
        seed: of moves, joints, ways and instants.
        rows: which; all where not given.
    """

    stand: Stand
    instants: int = 20
    seed: int = 0
    rows: tuple[str, ...] = (HOST_GONE, *ROWS)

    def run(self) -> Iterator[Outcome]:
        """All trials, one after the other."""
        for row in self.rows:
            ways = (LATE,) if row == HOST_GONE else ROWS[row]
            for number in range(self.instants):
                random = np.random.default_rng((self.seed, [HOST_GONE, *ROWS].index(row), number))
                yield Trial(self.stand, row, ways[number % len(ways)], random).run()


def lead_home(device: Device, home: float) -> bool:
    """Turn joints that are further than `home` (rad) from mid-stroke towards it; whether there are any."""
    plant, away = device.plant, False
    for j, angle in enumerate(plant.angles):
        far = abs(angle) > home
        plant.load[j] = -np.sign(angle) * HAND * device.brakes[j] if far else 0.0
        away = away or bool(far)
    return away


class Trial:
    """One failure of a rig that moves at random."""

    def __init__(self, stand: Stand, row: str, way: Way, random: np.random.Generator) -> None:
        self.stand, self.row, self.way, self.random = stand, row, way, random
        names = list(stand.machine.joints)
        self.joint = int(random.integers(len(names)))
        self.name = names[self.joint]
        self._next = 0

    def run(self) -> Outcome:
        """Bring the air, move, fail, watch, mend."""
        stand, way = self.stand, self.way
        stand.ready()
        stand.clear_peaks()
        begun = stand.clock.now()
        instant = self._until_failure(begun)
        if self.row == HOST_GONE:
            found, by, limit = self._host_gone()
        else:
            stand.clock.at(instant, lambda: way.begin(stand, self.joint))
            found, by, limit = self._found(instant)
        safe = self._safe(instant)
        turned = max(
            angle / (0.5 * joint.stops.mechanical_stroke)
            for angle, joint in zip(stand.peaks.angles, stand.machine.joints.values(), strict=True)
        )
        outcome = Outcome(
            self.row, way.name, self.name, (instant - begun) / SECOND, found, limit, by, safe, way.safe.value, turned,
            stand.peaks.above_supply, way.pushed,
        )  # fmt: skip
        self._mend()
        return outcome

    # Before

    def _until_failure(self, begun: int) -> int:
        """Move at random up to the cycle in which it fails; the instant (ns)."""
        random, stand = self.random, self.stand
        when = begun + round(random.uniform(*WHEN) * SECOND)
        while stand.clock.now() < when or (self.way.moving and not self._off()):
            self._move()
            stand.turn()
        if not self.way.moving:
            return stand.clock.now() + int(random.integers(1, round(stand.cycle * SECOND)))
        instant = stand.clock.now() + round(random.uniform(*ON_ITS_WAY) * SECOND)
        while stand.clock.now() + stand.cycle * SECOND < instant or abs(stand.truth.velocities[self.joint]) < GOING:
            stand.turn()
        return max(instant, stand.clock.now() + 1)

    def _move(self) -> None:
        """Ask for another place now and then."""
        now, stand = self.stand.clock.now(), self.stand
        if now >= self._next:
            self._next = now + round(self.random.uniform(*PAUSE) * SECOND)
            stand.host.demands = self._place()

    def _place(self) -> list[float]:
        half = [0.5 * SPAN * joint.stops.working_stroke for joint in self.stand.machine.joints.values()]
        return [float(self.random.uniform(-reach, reach)) for reach in half]

    def _off(self) -> bool:
        """Ask the joint to go far, in this cycle."""
        stand, reach = (
            self.stand,
            0.5 * SPAN * list(self.stand.machine.joints.values())[self.joint].stops.working_stroke,
        )
        here = stand.truth.angles[self.joint]
        side = -1.0 if here > 0.0 else 1.0
        demands = self._place()
        demands[self.joint] = float(self.random.uniform(0.0, reach)) * side
        if abs(demands[self.joint] - here) < self.way.way_to_go:
            return False
        stand.host.demands = demands
        self._next = stand.clock.now() + round(PAUSE[1] * SECOND)
        return True

    # After

    def _found(self, instant: int) -> tuple[float, str, float]:
        """After how long the fault was found (s), as what, and in which time it had to be (s)."""
        stand, way = self.stand, self.way
        limit = way.cycles * stand.cycle if way.cycles else way.seconds
        since: int | None = None if way.since is not None else instant
        for _ in range(round((limit + PATIENCE) / stand.cycle)):
            self._move()
            if stand.clock.now() < instant:
                stand.recorder.said.clear()
            stand.turn()
            now = stand.clock.now()
            if way.since is not None:
                beyond = way.since(stand, self.joint)
                since = (since or now - round(stand.cycle * SECOND)) if beyond else None
            said = "\n".join(stand.recorder.said)
            by = [fault for fault in way.found if TABLE[fault].title in said]
            if by and now > instant:
                if way.brief:
                    way.end(stand, self.joint)
                return (now - (since if since is not None else now)) / SECOND, TABLE[by[0]].title, limit
        return inf, "", limit

    def _host_gone(self) -> tuple[float, str, float]:
        """Stop the loop for a while: the far side has to centre its valves, and to let out the air later."""
        stand, machine = self.stand, self.stand.machine
        last = stand.clock.now()
        limit = machine.interface.watchdog_cycles * stand.cycle
        found, dumped, step = inf, inf, SECOND // 1000
        end = last + round(self.random.uniform(0.5, 2.0) * SECOND)
        while stand.clock.now() < end:
            stand.clock.wait(stand.clock.now() + step)
            stand.look()
            quiet = (stand.clock.now() - last) / SECOND
            if stand.truth.far is not FarState.RUNNING and found == inf:
                found = quiet
            if stand.truth.far is FarState.DUMPED and dumped == inf:
                dumped = quiet
        on_time = dumped <= machine.interface.dump_after + 1e-3 + 1e-9
        return (
            (found if on_time else inf),
            f"by the far side: centred, dumped after {1e3 * dumped:.0f} ms",
            limit + 1e-3,
        )

    def _safe(self, instant: int) -> float:
        """How long after the failure what is safe was reached, s."""
        stand = self.stand
        until = stand.clock.now() + round(SETTLES * SECOND)
        while True:
            if self._is_safe():
                return (stand.clock.now() - instant) / SECOND
            if stand.clock.now() >= until:
                return inf
            stand.turn()

    def _is_safe(self) -> bool:
        truth, empty = self.stand.truth, self.stand.machine.supply.ambient_pressure + EMPTY
        match self.way.safe:
            case Safe.TOLD:
                return True
            case Safe.HELD:
                return all(abs(speed) < STILL for speed in truth.velocities)
            case Safe.VENTED:
                return truth.pressures[self.joint] < empty
            case Safe.ALL_VENTED:
                return all(pressure < empty for pressure in truth.pressures)
            case Safe.OTHERS_VENTED:
                others = [pressure for j, pressure in enumerate(truth.pressures) if j != self.joint]
                return all(pressure < empty for pressure in others) and abs(truth.velocities[self.joint]) < STILL

    def _mend(self) -> None:
        """Heal, stop, let the air out, and reset."""
        stand = self.stand
        self.way.end(stand, self.joint)
        stand.host.edges = {"stop"}
        for _ in range(round((stand.machine.safety.hold_time + stand.machine.safety.vent_time) / stand.cycle)):
            stand.turn()
        # By hand, as anyone would who finds a joint at its stop without air.
        while stand.far.call(lead_home, HOME):
            stand.turn()
        stand.host.edges = {"reset"}
        for _ in range(8):
            stand.turn()


def judged(outcomes: list[Outcome]) -> dict[str, dict[str, float | int]]:
    """By row: trials, good ones, longest time to find, its limit, longest time to be safe, furthest turn."""
    rows: dict[str, dict[str, float | int]] = {}
    for row in dict.fromkeys(outcome.row for outcome in outcomes):
        own = [outcome for outcome in outcomes if outcome.row == row]
        rows[row] = {
            "trials": len(own),
            "good": sum(outcome.good for outcome in own),
            "found_after": max(outcome.found_after for outcome in own),
            "limit": max(outcome.limit for outcome in own),
            "safe_after": max(outcome.safe_after for outcome in own),
            "turned": max(outcome.turned for outcome in own),
            "above_supply": max(outcome.above_supply for outcome in own),
        }
    return rows
