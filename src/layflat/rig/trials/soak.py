"""A sound rig in random motion for hours: no fault may be found where there is none."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from layflat.machine import Machine
from layflat.rig.abilities import falls, payloads
from layflat.rig.clock import SECOND, VirtualClock
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.driver import Driver
from layflat.rig.drivers.simulated import SimulatedDriver
from layflat.rig.loop import Loop
from layflat.rig.safety.faults import Reaction
from layflat.rig.safety.states import State
from layflat.rig.trials.work import RandomWork

PAYLOAD_EVERY = 5.0  # mean time between two changes of the payload, s
STILL = 0.01  # speed of joints up to which an arm stands still, rad/s


@dataclass
class SoakResult:
    """What came of it."""

    hours: float
    moves: int = 0
    payloads: int = 0
    messages: list[str] = field(default_factory=list)  # what was said that should not have been
    trips: int = 0  # how often the rig was held or vented for nothing


def quiet(
    machine: Machine, device_of: Callable[[VirtualClock], VirtualDevice], hours: float, seed: int,
    progress: Callable[[float], None] | None = None, clock: VirtualClock | None = None,
    driver_of: Callable[[VirtualDevice], Driver] = SimulatedDriver,
) -> SoakResult:  # fmt: skip
    """Move at random for hours of simulated time, and note every fault; after a trip the rig is reset and goes on.

    The device is a sound one; the seed is that of moves and payloads; `progress` is told the share that is done. The
    loop waits by the clock; default: one that is never late. An arm that would fall takes and leaves payloads where it
    rests and is to rest: on its way that throws it out of its stroke, which is no false alarm.
    """
    clock, random = clock or VirtualClock(), np.random.default_rng(seed)
    host = RandomWork(machine, random)
    device = device_of(clock)
    driver = driver_of(device)
    driver.configure()
    loop = Loop(machine, driver, clock, host)
    driver.activate()
    supervisor = loop.supervisor
    found, (lightest, heaviest), thrown = SoakResult(hours), payloads(machine), falls(machine)
    end, next_payload, shown = round(hours * 3600 * SECOND), 0, 0
    while clock.now() < end:
        now, before = clock.now(), supervisor.state
        if before in {State.OFF, State.FAULT, State.STOPPED}:
            host.edges = {"reset"} if before is State.FAULT else {"start"}
        host.ask(now)
        stands = not thrown or (host.rests and bool(np.abs(device.plant.velocities).max() < STILL))
        if lightest < heaviest and now >= next_payload and stands:
            next_payload = now + round(random.exponential(PAYLOAD_EVERY) * SECOND)
            device.plant.payload = random.uniform(lightest, heaviest)
            found.payloads += 1
        loop.cycle()
        if before is not State.FAULT:
            found.trips += supervisor.state is State.FAULT
            if supervisor.ledger.now and supervisor.ledger.reaction > Reaction.WARN:
                found.messages.append(f"{now / SECOND:.2f} s: {supervisor.ledger.now.name}")
        if progress is not None and now - shown > SECOND:
            shown = now
            progress(now / end)
    driver.finalize()
    found.moves = host.moves
    return found
