"""A rig whose host requests all kinds of things at random, and in which all kinds of things fail."""

from collections.abc import Callable, Iterator
from math import inf, nan

import numpy as np

from layflat.machine import Machine
from layflat.rig.clock import NS_PER_SECOND
from layflat.rig.device_state import DeviceState
from layflat.rig.safety.faults import RigState
from tests.rig.fake_rig import Array, Rig

CHANCES = {"demand": 0.01, "stop": 0.004, "hold": 0.004, "start": 0.02, "reset": 0.01, "outputs": 0.01, "mishap": 0.01}
"""Chance of each request, and of a mishap, in a cycle."""

RARE_IN_A_START, RARITY = ("stop", "mishap"), 0.1
"""What happens less often in a soft start, which takes some seconds, and by what factor."""

LONGEST_MISHAP = 90  # cycles
LATE = (0.4, 1.3, 2.2)  # cycles by which a late cycle begins too late


def _set_item(array: int, joint: int, value: float) -> Callable[[Array, Array], None]:
    return lambda *arrays: arrays[array].__setitem__(joint, value)


class MishapRig:
    """Rig that goes from mishap to mishap, each of which is over after a while.

    Args:
        machine: the machine, an arm in a plane.
        seed: seed of all that happens.
    """

    def __init__(self, machine: Machine, seed: int) -> None:
        self.rig, self.machine = Rig(machine, np.zeros(len(machine.joints)), seed=seed, filled=False), machine
        self._rng = np.random.default_rng(seed)
        self._half = np.array([0.5 * joint.stops.working_stroke for joint in machine.joints.values()])
        self._left = 0  # cycles until a mishap is over
        self.counts = dict.fromkeys(self.mishaps, 0)

    def cycles(self, count: int) -> Iterator[Rig]:
        """Yield the rig after each of its cycles."""
        for _ in range(count):
            self._request()
            self._fail()
            yield self.rig.cycles(1)

    def _happens(self, name: str) -> bool:
        is_rare = name in RARE_IN_A_START and self.rig.supervisor.state is RigState.STARTING
        return bool(self._rng.random() < CHANCES[name] * (RARITY if is_rare else 1.0))

    def _request(self) -> None:
        rng, host, n = self._rng, self.rig.host, len(self._half)
        if self._happens("demand"):
            host.demands = (rng.uniform(-1.05, 1.05, n) * self._half).tolist()
            host.rates = (
                (rng.uniform(-2, 2, n).tolist(), rng.uniform(-5, 5, n).tolist()) if rng.random() < 0.3 else None
            )
            if rng.random() < 0.1:
                host.demands[int(rng.integers(n))] = float(rng.choice([nan, inf, 3.0]))
        host.stop, host.hold, host.start = (self._happens(name) for name in ("stop", "hold", "start"))
        host.reset = self._left == 0 and self._happens("reset")
        self.switched: list[tuple[int, bool]] = []  # digital outputs that are switched in this cycle
        if self._happens("outputs"):
            self.switched = [(int(rng.integers(8)), bool(rng.integers(2))) for _ in range(int(rng.integers(1, 4)))]
        host.switched = list(self.switched)

    def _fail(self) -> None:
        if self._left > 0:
            self._left -= 1
            if self._left == 0:
                self._mend()
        elif self._happens("mishap"):
            name = str(self._rng.choice(list(self.mishaps)))
            self.counts[name] += 1
            self.mishaps[name](int(self._rng.integers(len(self._half))))
            self._left = int(self._rng.integers(1, LONGEST_MISHAP))

    def _mend(self) -> None:
        driver, host, bench = self.rig.driver, self.rig.host, self.rig.bench
        driver.spoil, driver.link, driver.stopped = (lambda *_: None), None, False
        driver.device, driver.supply = DeviceState.RUNNING, None
        host.age, host.recording = 0.0, True
        bench.held[:], bench.escaping[:] = 9.0, 0.0

    @property
    def mishaps(self) -> dict[str, Callable[[int], object]]:
        """Return each mishap of a joint, or of the whole rig, by name."""
        rig, driver, host, bench = self.rig, self.rig.driver, self.rig.host, self.rig.bench

        def spoil(function: Callable[[Array, Array], None]) -> None:
            driver.spoil = function

        def spoil_at(array: int, value: float | None) -> Callable[[int], None]:
            return lambda j: spoil(_set_item(array, j, float(bench.exact()[array][j]) if value is None else value))

        def late(_: int) -> None:
            rig.clock.wait(rig.clock.now() + int(self.machine.cycle * NS_PER_SECOND * self._rng.choice(LATE)))

        return {
            "angle at rail": spoil_at(0, 5.0),
            "angle not a number": spoil_at(0, nan),
            "angle frozen": spoil_at(0, None),
            "pressure not a number": spoil_at(1, nan),
            "pressure too high": spoil_at(1, 6e5),
            "pressure frozen": spoil_at(1, None),
            "over-speed": lambda j: spoil(lambda angles, _: angles.__setitem__(j, -0.5 + 0.2 * (bench.k % 6))),
            "outside": lambda j: spoil_at(0, 1.12 * self._half[j])(j),
            "reply lost": lambda _: setattr(driver, "link", "lost"),
            "e-stop": lambda _: setattr(driver, "stopped", True),
            "device centred": lambda _: setattr(driver, "device", DeviceState.CENTRED),
            "device dumped": lambda _: setattr(driver, "device", DeviceState.DUMPED),
            "supply lost": lambda _: setattr(driver, "supply", 1.5e5),
            "supply unknown": lambda _: setattr(driver, "supply", nan),
            "spool stuck": lambda j: bench.held.__setitem__(j, float(self._rng.choice([0.0, 0.4, 1.0]))),
            "hose burst": lambda j: bench.escaping.__setitem__((j, int(self._rng.integers(2))), 0.15),
            "setpoints stale": lambda _: setattr(host, "age", 0.2),
            "recorder dead": lambda _: setattr(host, "recording", False),
            "late": late,
        }
