"""Process of the loop: its start and end, and a warmup loop that moves nothing, run before each deadline.

After a sleep of 5 ms the processor's caches no longer hold the loop's code and data: a cycle takes eight times as long
as one that follows another at once. A warmup runs the same code on data of its own; the real rig is not touched.
"""

import signal
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Self

import numpy as np

from layflat.arrays import Array
from layflat.errors import LayflatError, OutputError
from layflat.machine import Machine
from layflat.parallel import processors
from layflat.rig.clock import NS_PER_SECOND, WAKE_LEAD, MonotonicClock, PunctualClock, VirtualClock
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import Capabilities, Driver, RigCommand, SensorReading
from layflat.rig.loop import LoopRecorder, RigLoop
from layflat.rig.mailbox import Mailbox, RemoteHost, Setpoints
from layflat.rig.record import SHARED_COLUMNS, RowLayout
from layflat.rig.recorder.ring import Event, EventLevel, RecorderState, Ring
from layflat.rig.safety.faults import Fault, Reaction
from layflat.rig.system import go_realtime

# Level of a cycle's events, by its worst fault.
FAULT_LEVELS = [
    EventLevel.INFO,
    *(EventLevel.WARN if fault.reaction is Reaction.WARN else EventLevel.ERROR for fault in list(Fault)[1:]),
]
TIME_COLUMN, FAULT_COLUMN = (list(SHARED_COLUMNS).index(name) for name in ("time", "fault"))
STATE_CHANGE_MARK = " -> "  # in the event of a change of state
STARTS_WITHIN = 30.0  # time within which a recorder has to start, s
READING_COUNT = 64  # different readings of the warmup, in turn
ANGLE_NOISE, PRESSURE_NOISE, PRESSURE_RIPPLE = 2e-4, 200.0, (0.0, 3e3, 0.0, -3e3)  # of the readings, rad and Pa
WARMUP_CYCLES = 20  # cycles after which all code has been called once
MIN_CYCLE_LEADS = 4  # cycles shorter than so many leads of a punctual clock leave others too little of a processor


class RecorderClient(LoopRecorder):
    """Recorder's end in the loop: it pushes rows and events into a ring that a recorder empties, and never waits."""

    def __init__(self, ring: Ring) -> None:
        self._ring, self._time, self._level = ring, 0.0, EventLevel.INFO

    @classmethod
    def join(cls, path: Path) -> Self:
        """Attach to the ring in a file and wait until its recorder runs.

        Raise OutputError if the recorder has failed or does not run within 30 s, InputError if the file is no ring.
        """
        ring, until = Ring.attach(path), time.monotonic() + STARTS_WITHIN
        while not ring.is_recorder_alive() or ring.recorder is RecorderState.UNFINISHED:
            if ring.recorder is RecorderState.UNFINISHED or time.monotonic() > until:
                raise OutputError("the recorder did not start", where="rig", right="see that logs can be written")
            time.sleep(0.005)
        return cls(ring)

    def push(self, row: Array) -> None:
        """Push a row of `record.RowLayout`."""
        self._time, self._level = float(row[TIME_COLUMN]), FAULT_LEVELS[int(row[FAULT_COLUMN])]
        self._ring.push(row)

    def event(self, text: str) -> None:
        """Push a line for people, with the level of the worst fault of its cycle.

        A change of state in a cycle whose worst fault is a warning has level INFO.
        """
        mild = STATE_CHANGE_MARK in text and self._level is EventLevel.WARN
        self._ring.put_event(Event(self._time, EventLevel.INFO if mild else self._level, text))

    def is_alive(self) -> bool:
        """Return whether rows reach the disk."""
        return self._ring.is_recorder_alive()

    def end(self) -> None:
        """Mark the end of rows and events."""
        self._ring.end()


class RestingDriver(Driver):
    """Driver of a machine at rest that does not exist: it returns noisy readings and ignores commands."""

    def __init__(self, machine: Machine, late: int = 0) -> None:
        super().__init__()
        self.late = late
        rng, n, supply = np.random.default_rng(0), len(machine.joints), machine.supply.pressure
        self._machine, self._count, self._readings = machine, 0, list[SensorReading]()
        for k in range(READING_COUNT):
            angles = ANGLE_NOISE * rng.standard_normal(n)
            pressures = PRESSURE_RIPPLE[k % len(PRESSURE_RIPPLE)] + PRESSURE_NOISE * rng.standard_normal(n)
            self._readings.append(SensorReading(angles, pressures, supply, False, DeviceState.RUNNING))

    def read(self) -> SensorReading:
        """Return the next reading."""
        self._count += 1
        return self._readings[self._count % READING_COUNT]

    def write(self, command: RigCommand) -> None:
        """Ignore a command."""

    def _configure(self) -> Capabilities:
        return Capabilities.required_by(self._machine)

    def _deactivate(self) -> None: ...


class WarmupLoop:
    """Loop in motion with host, mailbox and recorder, on a machine that does not exist; a call performs one cycle."""

    def __init__(self, machine: Machine, late: int = 0) -> None:
        n, clock = len(machine.joints), VirtualClock()
        layout = RowLayout.for_machine(machine)
        path = Mailbox.create(layout)
        self._mailbox, ours = Mailbox(path, layout), Mailbox(path, layout)
        path.unlink()
        self.ring = Ring.create(layout.width, rows=READING_COUNT)
        self.ring.remove()
        self._setpoints = Setpoints([0.0] * n)
        driver = RestingDriver(machine, late)
        driver.configure()
        driver.activate()
        self.loop = RigLoop(machine, driver, clock, RemoteHost(ours, clock, n), RecorderClient(self.ring))
        self.loop.start_filled(driver.read())
        for _ in range(WARMUP_CYCLES):
            self()

    def __call__(self) -> None:
        """Perform one cycle."""
        self._mailbox.write_setpoints(self._setpoints)
        self.ring.beat(RecorderState.RECORDING)
        self.loop.cycle()
        self.ring.drain()


def _clock_of(machine: Machine, driver: Driver) -> MonotonicClock:
    """Return the clock of a loop, after the code of its cycle was loaded; where a processor is free it warms that up.

    A device that runs the control law itself leaves so little to the loop that none of it is needed.
    """
    if driver.runs_law:
        return MonotonicClock()
    warmup = WarmupLoop(machine, driver.late)
    roomy = machine.cycle * NS_PER_SECOND >= MIN_CYCLE_LEADS * WAKE_LEAD and processors() > 1
    return PunctualClock(warmup) if roomy else MonotonicClock()


def run_loop(
    machine: Machine,
    driver: Callable[[], Driver],
    mailbox: Path,
    recorder: Callable[[], LoopRecorder],
    pipe: Connection,
) -> None:
    """Run the loop, as the main function of its process, until the host has ended or died and the air is out.

    It ignores Ctrl-C, requests real-time privileges, finalizes the driver, and removes the mailbox's file.

    Args:
        machine: description of the rig.
        driver: factory of the driver.
        mailbox: file of shared memory, from `Mailbox.create`.
        recorder: factory of the recorder's end.
        pipe: receives (success, lines for people) once the loop runs, and again once it has ended.
    """
    # Ctrl-C goes to all processes of a terminal; the host turns it into a controlled stop.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        device_driver = driver()
        with ExitStack() as ending:
            ending.callback(device_driver.finalize)
            device_driver.configure().check(machine)
            clock = _clock_of(machine, device_driver)
            shared = Mailbox(mailbox, RowLayout.for_machine(machine))
            ending.callback(shared.close)
            keeper = recorder()
            ending.callback(keeper.end)
            ending.callback(device_driver.finalize)  # before all others; the first one then does nothing
            loop = RigLoop(machine, device_driver, clock, RemoteHost(shared, clock, len(machine.joints)), keeper)
            refused = go_realtime()
            for line in refused:
                keeper.event(line)
            device_driver.activate()
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
