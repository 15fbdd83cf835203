"""The loop in a process of its own: what runs there, and how it begins and ends."""

import signal
from collections.abc import Callable
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection
from pathlib import Path

from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.rig.clock import LEAD, SECOND, MonotonicClock, PunctualClock
from layflat.rig.driver import Driver
from layflat.rig.loop import Loop, Recorder
from layflat.rig.mailbox import Mailbox, RemoteHost
from layflat.rig.record import Layout
from layflat.rig.system import go_realtime, processors
from layflat.rig.warmup import WarmupLoop

LEADS = 4  # shorter cycles than so many leads of a punctual clock leave others too little of a processor


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
        warmup, roomy = WarmupLoop(machine), machine.cycle * SECOND >= LEADS * LEAD and processors() > 1
        clock = PunctualClock(warmup) if roomy else MonotonicClock()
        shared, made = Mailbox(mailbox, Layout.of(machine)), driver()
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
