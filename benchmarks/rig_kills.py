"""kill -9 of a rig's recorder, loop or host in the middle of a move: what is left of the log, and is the rig vented.

    python -m benchmarks.rig_kills --count 50

Every trial has processes of its own; the virtual rig stays, in real time, over Modbus TCP.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import signal
import tempfile
import time
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

import numpy as np

from layflat.machine import Machine, changed, load
from layflat.rig.device.process import DeviceProcess, ModbusPort
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.drivers import create_driver
from layflat.rig.mailbox import Mailbox
from layflat.rig.plan import DemandPlan, EarlyEndError, PlanRunner
from layflat.rig.record import RowLayout
from layflat.rig.recorded import RecordedSession
from layflat.rig.recorder.process import part_path
from layflat.rig.recorder.repair import repair
from layflat.rig.recorder.run import read_run
from layflat.virtual_rig import VirtualRig

VICTIMS = ("recorder", "loop", "host")

EMPTY = 0.2e5
"""Gauge pressure below which hoses are taken to be empty, Pa."""

HOME, HAND = 0.5, 2.0
"""Joints that are further from mid-stroke (rad) are led back by a hand of so many times what the brake holds."""

PATIENCE = 30.0
"""For anything that has to happen, s."""


class Result(NamedTuple):
    """Result of a trial."""

    victim: str
    missing: float
    """Of the log, up to the kill and within; s."""
    vented: float
    """Until all hoses were empty, s; infinite if they were not."""
    repaired: bool
    """Whether the log was left unfinished."""


def patient(machine: Machine) -> Machine:
    """The machine on a computer that others use too: replies may take long, and a pause is no silence."""
    for path, value in (
        ("interface.modbus.timeout", 0.1),
        ("interface.watchdog_cycles", 40),
        ("interface.dump_after", 0.4),
        ("safety.setpoint_age", 0.3),
        ("safety.air_residual", 1.0),
    ):
        machine = changed(machine, path, value)
    return machine


def host(machine: Machine, address: str, place: str, pipe: Connection) -> None:
    """Run the host's process: swing the arm until the run ends, or it is killed."""
    with RecordedSession(machine, partial(create_driver, address, machine), address, Path(place)) as rig:
        performance = PlanRunner(rig)
        performance.start_air()
        pipe.send((rig.session.process.pid, rig.recorder.pid, str(rig.session.mailbox)))
        times = np.arange(0.1, 20.0, 0.7)
        swings = [[0.2 * (-1) ** k, 0.15 * (-1) ** k] for k in range(len(times))]
        try:
            performance.follow(DemandPlan(times.tolist(), swings, 20.0))
        except EarlyEndError as error:
            pipe.send(str(error))


def pressure(device: VirtualDevice) -> float:
    """The highest gauge pressure in any hose, Pa."""
    device.tick()
    return float(device.plant.pressures.max() - device.line.ambient)


def lead_home(device: VirtualDevice) -> bool:
    """Turn joints by hand that a killed loop has left device out; whether there are any."""
    device.tick()
    plant, away = device.plant, False
    for j, angle in enumerate(plant.angles):
        out = abs(angle) > HOME
        plant.load[j] = -np.sign(angle) * HAND * device.brakes[j] if out else 0.0
        away = away or bool(out)
    return away


def trial(device: DeviceProcess, machine: Machine, victim: str, instant: float, folder: Path) -> Result:
    """Kill one of the three processes so many seconds after the first demand."""
    place = folder / f"{victim}-{time.monotonic_ns()}.mcap"
    context = multiprocessing.get_context("spawn")
    mine, its = context.Pipe()
    process = context.Process(target=host, args=(machine, device.address, str(place), its), name="host")
    _until(lambda: not device.call(lead_home))
    process.start()
    its.close()
    if not mine.poll(2.0 * PATIENCE):
        raise TimeoutError("the rig did not start")
    loop, recorder, mailbox = mine.recv()
    shown = Mailbox(Path(mailbox), RowLayout.for_machine(machine))
    time.sleep(0.1 + instant)
    assert process.pid is not None
    row = shown.read_row()
    assert row is not None
    known = float(row[0])
    os.kill({"loop": loop, "recorder": recorder, "host": process.pid}[victim], signal.SIGKILL)
    vented = _until(lambda: device.call(pressure) < EMPTY)
    _until(lambda: not any(_runs(pid) for pid in (loop, recorder)))
    process.join(PATIENCE)
    shown.close()
    part = part_path(place)
    cut = part.exists()
    if cut:
        done = repair(part)
        assert done is not None
        place = done[0]
    return Result(victim, _missing(place, known), vented, cut)


def _missing(place: Path, known: float) -> float:
    """Seconds that a log lacks, up to an instant of the loop's time and within."""
    log = read_run(place)
    times, elapsed = log["time"].to_numpy(), log["elapsed"].to_numpy()
    gaps = np.maximum(np.diff(times) - elapsed[1:] - 0.002, 0.0)
    return float(max(known - times[-1], 0.0) + gaps.sum())


def _until(so: Callable[[], bool]) -> float:
    """Seconds until a condition holds; infinite if it does not."""
    begun = time.monotonic()
    while time.monotonic() - begun < PATIENCE:
        if so():
            return time.monotonic() - begun
        time.sleep(0.02)
    return float("inf")


def _runs(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def main() -> None:
    """Kill, and tell."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=50, help="instants, of each process")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    machine, random = patient(load("paper-arm")), np.random.default_rng(given.seed)
    results: list[Result] = []
    with tempfile.TemporaryDirectory() as folder, DeviceProcess(VirtualRig(machine), machine, ModbusPort()) as device:
        for k in range(given.count):
            for victim in VICTIMS:
                results.append(trial(device, machine, victim, random.uniform(0.0, 1.5), Path(folder)))
                print(f"{k + 1:3d} {results[-1]}", flush=True)
    for victim in VICTIMS:
        own = [one for one in results if one.victim == victim]
        missing, vented = max(1e3 * one.missing for one in own), max(one.vented for one in own)
        print(
            f"kill -9 of the {victim}: {len(own)} times, missing at most {missing:.0f} ms, vented within {vented:.1f} s"
        )


if __name__ == "__main__":
    main()
