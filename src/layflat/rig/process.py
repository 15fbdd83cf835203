"""The loop in a process of its own: how it begins and ends, and a loop that moves nothing, run before each deadline.

A processor that slept for 5 ms has forgotten code and data of the loop: a cycle takes eight times as long as one that
follows another. A warmup is the same code with data of its own; nothing of the real rig is touched.
"""

import signal
from collections.abc import Callable
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.parallel import processors
from layflat.rig.clock import LEAD, SECOND, MonotonicClock, PunctualClock, VirtualClock
from layflat.rig.driver import Capabilities, Command, DeviceState, Driver, Reading
from layflat.rig.loop import Loop, Recorder
from layflat.rig.mailbox import Mailbox, RemoteHost, Setpoints
from layflat.rig.record import Layout
from layflat.rig.recorder.client import RecorderClient
from layflat.rig.recorder.ring import RecorderState, Ring
from layflat.rig.system import go_realtime

READINGS = 64  # given one after the other
ANGLE_NOISE, PRESSURE_NOISE, RIPPLE = 2e-4, 200.0, (0.0, 3e3, 0.0, -3e3)  # of the readings, rad and Pa
UNTIL_LOADED = 20  # cycles after which everything was called once
LEADS = 4  # shorter cycles than so many leads of a punctual clock leave others too little of a processor


class Resting(Driver):
    """A machine at rest, of which nothing is real: it gives noisy readings and forgets commands."""

    def __init__(self, machine: Machine, late: int = 0) -> None:
        super().__init__()
        self.late = late
        rng, n, supply = np.random.default_rng(0), len(machine.joints), machine.supply.pressure
        self._machine, self._count, self._readings = machine, 0, list[Reading]()
        for k in range(READINGS):
            angles = ANGLE_NOISE * rng.standard_normal(n)
            pressures = RIPPLE[k % len(RIPPLE)] + PRESSURE_NOISE * rng.standard_normal(n)
            self._readings.append(Reading(angles, pressures, supply, False, DeviceState.RUNNING))

    def read(self) -> Reading:
        """The next reading."""
        self._count += 1
        return self._readings[self._count % READINGS]

    def write(self, command: Command) -> None:
        """Nothing moves."""

    def _configure(self) -> Capabilities:
        return Capabilities.needed(self._machine)

    def _deactivate(self) -> None: ...


class WarmupLoop:
    """Cycles of a loop in motion, with everything around it, on a machine that is not there."""

    def __init__(self, machine: Machine, late: int = 0) -> None:
        n, clock = len(machine.joints), VirtualClock()
        layout = Layout.of(machine)
        path = Mailbox.create(layout)
        self._mailbox, ours = Mailbox(path, layout), Mailbox(path, layout)
        path.unlink()
        self.ring = Ring.create(layout.width, rows=READINGS)
        self.ring.remove()
        self._wanted = Setpoints([0.0] * n)
        driver = Resting(machine, late)
        driver.configure()
        driver.activate()
        self.loop = Loop(machine, driver, clock, RemoteHost(ours, clock, n), RecorderClient(self.ring))
        self.loop.begin(driver.read())
        for _ in range(UNTIL_LOADED):
            self()

    def __call__(self) -> None:
        """One cycle."""
        self._mailbox.ask(self._wanted)
        self.ring.beat(RecorderState.RECORDING)
        self.loop.cycle()
        self.ring.take()


def run_loop(
    machine: Machine, driver: Callable[[], Driver], mailbox: Path, recorder: Callable[[], Recorder], pipe: Connection
) -> None:
    """Main function of the process: loop until the host has ended or died, and the air is out.

    Driver and recorder's end are made here. The pipe is told once the loop runs and once it has ended: whether all is
    well, and lines for people.
    """
    # Ctrl-C goes to all processes of a terminal; the host turns it into a controlled stop.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        # What the first cycle calls is loaded in any case, and before every cycle if a processor can be had for that.
        made = driver()
        warmup, roomy = WarmupLoop(machine, made.late), machine.cycle * SECOND >= LEADS * LEAD and processors() > 1
        clock = PunctualClock(warmup) if roomy else MonotonicClock()
        shared = Mailbox(mailbox, Layout.of(machine))
        keeper = recorder()
        with ExitStack() as ending:
            for end in (shared.close, keeper.end, made.finalize):  # the last one first
                ending.callback(end)
            made.configure().check(machine)
            loop = Loop(machine, made, clock, RemoteHost(shared, clock, len(machine.joints)), keeper)
            refused = go_realtime()
            for line in refused:
                keeper.event(line)
            made.activate()
            pipe.send((True, refused))
            loop.run()
        said = True, [loop.deadlines.summary()]
    except LayflatError as error:
        said = False, [str(error)]
    except Exception as error:  # whatever happens, the host is told; the device centres by itself
        said = False, [f"the loop broke: {type(error).__name__}: {error}"]
    mailbox.unlink(missing_ok=True)  # who has it open keeps it; the host may be gone
    with suppress(OSError):
        pipe.send(said)
