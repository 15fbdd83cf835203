"""The command that tries every fault on a virtual rig: rig faults."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat.cli.app import MachineName, print_table
from layflat.cli.rig import FAULT, rigs
from layflat.errors import InputError

if TYPE_CHECKING:
    from concurrent.futures import Future
    from queue import Queue

    from layflat.machine import Machine
    from layflat.rig.trials.campaign import Outcome
    from layflat.rig.trials.soak import SoakResult

LONG_ENOUGH = 0.05  # time limit of a reply in a trial, s: time that passes for the processor is none for the rig

HEADER = ["fault", "good", "found after (ms)", "limit (ms)", "safe after (s)", "furthest (% of stroke)"]


@rigs.command("faults")
def faults(
    machine: MachineName,
    instants: Annotated[int, typer.Option(min=1, help="at which each fault is tried, on each protocol")] = 20,
    protocol: Annotated[str, typer.Option(help="modbus, serial or both")] = "both",
    quiet: Annotated[str, typer.Option(help="simulated time in which nothing may be found; 0 s for none")] = "1 h",
    seed: Annotated[int, typer.Option(help="of moves, joints and instants")] = 0,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="all trials as JSON")] = Path(
        "build/rig/faults.json"
    ),
) -> None:
    """Try every fault on a virtual rig, at random instants of random moves; then move for long without any.

    Exit status 3 where a fault was missed, found too late, or found where there was none.
    """
    from layflat import extras  # noqa: PLC0415
    from layflat.description import units as u  # noqa: PLC0415
    from layflat.files import check_file, write_text  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.rig.drivers.address import PACKAGES  # noqa: PLC0415
    from layflat.rig.system import require_posix  # noqa: PLC0415
    from layflat.rig.trials.campaign import judged  # noqa: PLC0415

    if protocol not in (*PACKAGES, "both"):
        raise InputError(f"{protocol!r} is not a protocol", where="--protocol", right="give modbus, serial or both")
    chosen = list(PACKAGES) if protocol == "both" else [protocol]
    require_posix("rig faults")
    extras.require("rig", *(package for one in chosen for package in PACKAGES[one]), where="rig faults")
    hours = u.quantity(quiet, u.TIME, "--quiet") / 3600.0
    described = load(machine)
    check_file(out, costly=True)
    outcomes, found = _tried(described, chosen, instants, seed, hours)
    rows = {name: judged(own) for name, own in outcomes.items()}
    written = {
        "machine": described.name,
        "seed": seed,
        "rows": rows,
        "quiet": asdict(found) if found is not None else None,
        "trials": {name: [one._asdict() | {"good": one.good} for one in own] for name, own in outcomes.items()},
    }
    _print(rows, found)
    write_text(out, json.dumps(written, indent=1))
    typer.echo(f"wrote {out}")
    trips = found.trips if found is not None else 0
    if trips or not all(one.good for own in outcomes.values() for one in own):
        raise typer.Exit(FAULT)


def _tried(
    machine: Machine, protocols: list[str], instants: int, seed: int, hours: float
) -> tuple[dict[str, list[Outcome]], SoakResult | None]:
    """Outcomes by protocol, and of the quiet time; each in a process of its own."""
    from concurrent.futures import FIRST_COMPLETED, wait  # noqa: PLC0415
    from multiprocessing import get_context  # noqa: PLC0415

    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn  # noqa: PLC0415

    from layflat.parallel import process_pool  # noqa: PLC0415
    from layflat.rig.trials.cases import ROWS  # noqa: PLC0415

    trials = instants * len(ROWS)
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:.0f} %"))
    with (
        get_context("spawn").Manager() as manager,
        process_pool(2) as submit,
        Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True) as progress,
    ):
        done: Queue[Any] = manager.Queue()
        bars = {name: progress.add_task(f"faults, {name}", total=trials) for name in protocols}
        jobs: dict[str, Future[Any]] = {
            name: submit(campaign, machine, name, instants, seed, done) for name in protocols
        }
        if hours > 0.0:
            bars["quiet"] = progress.add_task("moves without a fault", total=1.0)
            jobs["quiet"] = submit(stay_quiet, machine, hours, seed, done)
        left = set(jobs.values())
        while left:
            _, left = wait(left, timeout=0.2, return_when=FIRST_COMPLETED)
            while not done.empty():
                name, share = done.get()
                progress.update(bars[name], completed=share)
        results = {name: job.result() for name, job in jobs.items()}
    return {name: results[name] for name in protocols}, results.get("quiet")


def campaign(machine: Machine, protocol: str, instants: int, seed: int, done: Queue[Any]) -> list[Outcome]:
    """All trials over a protocol; the device is in another process, in step with this one."""
    from layflat.cli.virtual_rig import VirtualRig  # noqa: PLC0415
    from layflat.machine import changed  # noqa: PLC0415
    from layflat.rig.device.process import DeviceProcess, ModbusPort, SerialPort  # noqa: PLC0415
    from layflat.rig.drivers.address import driver_of  # noqa: PLC0415
    from layflat.rig.trials.campaign import campaign as trials  # noqa: PLC0415
    from layflat.rig.trials.rig import TrialRig  # noqa: PLC0415

    patient = changed(machine, f"interface.{protocol}.timeout", LONG_ENOUGH)
    at = ModbusPort() if protocol == "modbus" else SerialPort()
    outcomes = []
    with DeviceProcess(VirtualRig(patient, seed), patient, at, lockstep=True) as device:
        rig = TrialRig(patient, device, driver_of(device.address, patient))
        for outcome in trials(rig, instants, seed):
            outcomes.append(outcome)
            done.put((protocol, len(outcomes)))
    return outcomes


def stay_quiet(machine: Machine, hours: float, seed: int, done: Queue[Any]) -> SoakResult:
    """Random moves of a sound rig, with the device in the same process."""
    from layflat.cli.virtual_rig import VirtualRig  # noqa: PLC0415
    from layflat.rig.trials.soak import quiet  # noqa: PLC0415

    return quiet(machine, VirtualRig(machine, seed), hours, seed, lambda share: done.put(("quiet", share)))


def _print(judged: dict[str, dict[str, dict[str, float | int]]], found: SoakResult | None) -> None:
    for name, rows in judged.items():
        cells = [
            [
                row,
                f"{of['good']:.0f} of {of['trials']:.0f}",
                *(f"{1e3 * of[time]:.0f}" for time in ("found_after", "limit")),
                f"{of['safe_after']:.2f}",
                f"{100 * of['turned']:.0f}",
            ]
            for row, of in rows.items()
        ]
        print_table(HEADER, cells, f"over {name}")
        typer.echo()
    if found is not None:
        moves = f"{found.moves} moves and {found.payloads} changes of the payload"
        typer.echo(f"{found.hours:.3g} h of {moves}: {found.trips} false trips")
