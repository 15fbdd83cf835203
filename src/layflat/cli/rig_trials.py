"""Commands that check a rig against its description, and that try whether each fault is found."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat.cli.bars import busy
from layflat.cli.common import MachineName, print_table
from layflat.cli.groups import rigs
from layflat.cli.rig import FAULT_EXIT, Address, driver_at
from layflat.errors import InputError
from layflat.virtual_rig import VirtualRig

if TYPE_CHECKING:
    from concurrent.futures import Future
    from queue import Queue

    from layflat.machine import Machine
    from layflat.rig.trials.campaign import TrialOutcome
    from layflat.rig.trials.soak import SoakResult


@rigs.register("check", "paper-arm --driver simulated", "mine.toml --driver serial:///dev/ttyACM0 --air")
def check_rig(
    machine: MachineName,
    driver: Address,
    air: Annotated[bool, typer.Option("--air", help="bring the air and move each joint by some degrees")] = False,
) -> None:
    """Check a rig before it is used: link, timing, sensors.

    With --air it checks the signs of valves and sensors, too. Exit status 3 if a check failed.
    """
    from layflat.machine import load  # noqa: PLC0415
    from layflat.rig.check import check_in_subprocess  # noqa: PLC0415

    described = load(machine)
    factory, _ = driver_at(driver, described)
    with busy("starting") as show:
        findings = check_in_subprocess(described, factory, air=air, tell=show)
    rows = [[one.what, one.finding, one.action or "passed"] for one in findings]
    print_table(["check", "found", "action"], rows, f"{described.name} at {driver}")
    wrong = sum(not one.has_passed for one in findings)
    if wrong:
        typer.echo(f"{wrong} check{'s' if wrong > 1 else ''} failed")
        raise typer.Exit(FAULT_EXIT)
    typer.echo("all checks passed" if air else "all checks without air passed; --air tries valves and signs")


TRIAL_TIMEOUT = 0.05  # of a reply in a trial, s: the rig's clock does not run while the processor works

TRIAL_COLUMNS = ["fault", "good", "found after (ms)", "limit (ms)", "safe after (s)", "furthest (% of stroke)"]


@rigs.register("faults", "paper-arm", 'paper-arm --instants 5 --quiet "0 s"')
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
    """Try every fault on a virtual rig.

    Each at random instants of random moves; then the rig moves for long without any. Exit status 3 where a fault was
    missed, found too late, or found where there was none.
    """
    from layflat import extras  # noqa: PLC0415
    from layflat.description import units as u  # noqa: PLC0415
    from layflat.files import check_file, write_text  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.rig.drivers import PROTOCOL_PACKAGES  # noqa: PLC0415
    from layflat.rig.system import require_posix  # noqa: PLC0415
    from layflat.rig.trials.campaign import summarize_outcomes  # noqa: PLC0415

    if protocol not in (*PROTOCOL_PACKAGES, "both"):
        raise InputError(f"{protocol!r} is not a protocol", where="--protocol", right="give modbus, serial or both")
    chosen = list(PROTOCOL_PACKAGES) if protocol == "both" else [protocol]
    require_posix("rig faults")
    extras.require("rig", *(package for one in chosen for package in PROTOCOL_PACKAGES[one]), where="rig faults")
    hours = u.quantity(quiet, u.TIME, "--quiet") / 3600.0
    described = load(machine)
    check_file(out, costly=True)
    outcomes, soak = _run_trials(described, chosen, instants, seed, hours)
    rows = {name: summarize_outcomes(protocol_outcomes) for name, protocol_outcomes in outcomes.items()}
    written = {
        "machine": described.name,
        "seed": seed,
        "rows": rows,
        "quiet": asdict(soak) if soak is not None else None,
        "trials": {
            name: [one._asdict() | {"good": one.is_good} for one in protocol_outcomes]
            for name, protocol_outcomes in outcomes.items()
        },
    }
    _print_trials(rows, soak)
    write_text(out, json.dumps(written, indent=1))
    typer.echo(f"wrote {out}")
    trips = soak.trips if soak is not None else 0
    if trips or not all(one.is_good for protocol_outcomes in outcomes.values() for one in protocol_outcomes):
        raise typer.Exit(FAULT_EXIT)


def _run_trials(
    machine: Machine, protocols: list[str], instants: int, seed: int, hours: float
) -> tuple[dict[str, list[TrialOutcome]], SoakResult | None]:
    """Run the trials of each protocol and the quiet time in other processes; return outcomes by protocol, and soak.

    `hours` is the quiet time, simulated; for 0 the soak is None.
    """
    from concurrent.futures import FIRST_COMPLETED, wait  # noqa: PLC0415
    from multiprocessing import get_context  # noqa: PLC0415

    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn  # noqa: PLC0415

    from layflat.parallel import process_pool  # noqa: PLC0415
    from layflat.rig.trials.cases import FAULT_CASES  # noqa: PLC0415

    trials = instants * len(FAULT_CASES)
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:.0f} %"))
    with (
        get_context("spawn").Manager() as manager,
        process_pool(2) as submit,
        Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True) as progress,
    ):
        done: Queue[Any] = manager.Queue()
        bars = {name: progress.add_task(f"faults, {name}", total=trials) for name in protocols}
        jobs: dict[str, Future[Any]] = {
            name: submit(run_campaign, machine, name, instants, seed, done) for name in protocols
        }
        if hours > 0.0:
            bars["quiet"] = progress.add_task("moves without a fault", total=1.0)
            jobs["quiet"] = submit(run_quiet, machine, hours, seed, done)
        left = set(jobs.values())
        while left:
            _, left = wait(left, timeout=0.2, return_when=FIRST_COMPLETED)
            while not done.empty():
                name, share = done.get()
                progress.update(bars[name], completed=share)
        results = {name: job.result() for name, job in jobs.items()}
    return {name: results[name] for name in protocols}, results.get("quiet")


def run_campaign(machine: Machine, protocol: str, instants: int, seed: int, done: Queue[Any]) -> list[TrialOutcome]:
    """Run all trials over a protocol; the device runs in another process, in lockstep with this one.

    Args:
        machine: machine of the rig.
        protocol: modbus or serial.
        instants: number of instants at which each fault is tried.
        seed: seed of moves, joints and instants.
        done: receives (protocol, number of trials done).
    """
    from layflat.machine import changed  # noqa: PLC0415
    from layflat.rig.device.process import DeviceProcess, ModbusPort, SerialPort  # noqa: PLC0415
    from layflat.rig.drivers import create_driver  # noqa: PLC0415
    from layflat.rig.trials.campaign import run_campaign as trials  # noqa: PLC0415
    from layflat.rig.trials.rig import TrialRig  # noqa: PLC0415

    patient = changed(machine, f"interface.{protocol}.timeout", TRIAL_TIMEOUT)
    at = ModbusPort() if protocol == "modbus" else SerialPort()
    outcomes = []
    with DeviceProcess(VirtualRig(patient, seed), patient, at, lockstep=True) as device:
        rig = TrialRig(patient, device, create_driver(device.address, patient))
        for outcome in trials(rig, instants, seed):
            outcomes.append(outcome)
            done.put((protocol, len(outcomes)))
    return outcomes


def run_quiet(machine: Machine, hours: float, seed: int, done: Queue[Any]) -> SoakResult:
    """Run random moves of a rig without faults, with the device in the same process.

    Args:
        machine: machine of the rig.
        hours: simulated time, h.
        seed: seed of the moves.
        done: receives ("quiet", fraction of the time done).
    """
    from layflat.rig.trials.soak import run_soak  # noqa: PLC0415

    return run_soak(machine, VirtualRig(machine, seed), hours, seed, lambda share: done.put(("quiet", share)))


def _print_trials(judged: dict[str, dict[str, dict[str, float | int]]], soak: SoakResult | None) -> None:
    """Print a table of the judged fault trials for each wire, and the false trips of a soak test."""
    for name, rows in judged.items():
        cells = [
            [
                row,
                f"{values['good']:.0f} of {values['trials']:.0f}",
                *(f"{1e3 * values[time]:.0f}" for time in ("detection_time", "limit")),
                f"{values['safe_after']:.2f}",
                f"{100 * values['turned']:.0f}",
            ]
            for row, values in rows.items()
        ]
        print_table(TRIAL_COLUMNS, cells, f"over {name}")
        typer.echo()
    if soak is not None:
        moves = f"{soak.moves} moves and {soak.payloads} changes of the payload"
        typer.echo(f"{soak.hours:.3g} h of {moves}: {soak.trips} false trips")
