"""The loop of a rig in real time at 200 Hz: how late cycles are, and what they cost, beside a busy process."""

from __future__ import annotations

import multiprocessing
import os
import time
from multiprocessing.connection import Connection
from multiprocessing.synchronize import Event
from pathlib import Path

import numpy as np

from layflat.machine import load
from layflat.rig.clock import PunctualClock
from layflat.rig.loop import RigLoop
from layflat.rig.mailbox import Mailbox, RemoteHost, Setpoints
from layflat.rig.process import RestingDriver, WarmupLoop
from layflat.rig.record import RowLayout
from layflat.rig.system import go_realtime

SECONDS = 10.0
"""Of real time that are measured."""

PANEL_RATE = 30.0
"""Pictures a second of what stands for a panel."""


def panel(mailbox: str, over: Event) -> None:
    """What a panel does: it asks, looks on, and computes pictures."""
    box, n = Mailbox(Path(mailbox), RowLayout.for_machine(load("paper-arm"))), 400
    while not over.is_set():
        begin = time.perf_counter()
        box.write_setpoints(Setpoints([0.0, 0.0]))
        box.read_row()
        for _ in range(3):
            picture = np.random.default_rng(0).standard_normal((n, n))
            picture @ picture
        time.sleep(max(0.5 / PANEL_RATE, 1.0 / PANEL_RATE - (time.perf_counter() - begin)))


def work(mailbox: str, sender: Connection) -> None:
    """The loop's process: cycles of an arm at rest, with air and demands."""
    machine = load("paper-arm")
    clock, driver = PunctualClock(WarmupLoop(machine)), RestingDriver(machine)
    driver.configure()
    driver.activate()
    shared = Mailbox(Path(mailbox), RowLayout.for_machine(machine))
    loop = RigLoop(machine, driver, clock, RemoteHost(shared, clock, 2))
    refused = go_realtime()
    loop.start_filled(driver.read())
    for _ in range(100):
        loop.cycle()
    loop.deadlines.reset_statistics()
    for _ in range(round(SECONDS / loop.deadlines.cycle)):
        loop.cycle()
    late, busy = loop.deadlines.lateness_at, loop.deadlines.compute_at
    sender.send(
        {
            "loop_lateness_median_us": 1e6 * late(0.5),
            "loop_lateness_99_percent_us": 1e6 * late(0.99),
            "loop_compute_median_us": 1e6 * busy(0.5),
            "loop_compute_99_percent_us": 1e6 * busy(0.99),
            "loop_missed_deadlines": float(loop.deadlines.missed),
            "loop_realtime_refused": float(len(refused)),
            "loop_state": float(loop.supervisor.state),
        }
    )


def measure() -> dict[str, float]:
    """All figures by name."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    context, path = multiprocessing.get_context("spawn"), Mailbox.create(RowLayout.for_machine(load("paper-arm")))
    over, (mine, its) = context.Event(), context.Pipe()
    busy = context.Process(target=panel, args=(str(path), over), daemon=True)
    loop = context.Process(target=work, args=(str(path), its), daemon=True)
    try:
        busy.start()
        loop.start()
        if not mine.poll(SECONDS + 120.0):
            raise TimeoutError("the loop did not answer")
        found: dict[str, float] = mine.recv()
    finally:
        over.set()
        loop.join(10.0)
        busy.join(10.0)
        path.unlink()
    return found


MEANING = {
    "loop_lateness_median_us": "a rig's loop at 200 Hz beside a busy panel: a cycle after its deadline; aim 150",
    "loop_lateness_99_percent_us": "the same, kept by 99 % of the cycles",
    "loop_compute_median_us": "a whole cycle: controllers, safety, hand-off to recorder, snapshot; aim 50",
    "loop_compute_99_percent_us": "the same, kept by 99 % of the cycles",
    "loop_missed_deadlines": "of 2000",
    "loop_realtime_refused": "of priority, locked memory, own processor, exact timers: not granted here",
}


if __name__ == "__main__":
    for name, value in measure().items():
        print(f"{name:32s} {value:.4g}")
