"""The table of test benches: a kind is one folder beside this file, and one line here.

A folder has a `description` with the class `DESCRIPTION`, and a `model` with the `BENCH` that fits its logs; `builtin`
holds descriptions. Machines are described in a room of their own; two kinds of bench take their logs.
"""

from __future__ import annotations

from importlib import import_module

from layflat.identify.benches.contract import Bench, BenchDescription, Logs, check_known
from layflat.machine import Machine

KINDS = {"friction rig": "rod", "regulated joint": "regulated", "vessel": "vessel"}
"""Folders by the `kind` at the top of a description."""

MOVING, TURNED = "moving", "joint_loops"
"""Folders for machines: those that move by their valves, and a joint that is turned slowly while torque is measured."""


def description_class(kind: str) -> type[BenchDescription]:
    """The class that validates descriptions of a kind."""
    return _part(KINDS[kind], "description").DESCRIPTION  # type: ignore[no-any-return]


def bench_of(described: Machine | BenchDescription, logs: Logs) -> Bench:
    """The bench of a description with these logs: a joint is turned slowly where only torque was measured."""
    if isinstance(described, BenchDescription):
        folder = KINDS[described.kind]
    else:
        turned = all("torque" in log and "voltage" not in log for log in logs.values())
        folder = TURNED if turned else MOVING
    return _part(folder, "model").BENCH  # type: ignore[no-any-return]


def chosen_blocks(bench: Bench, fitted: str | None) -> list[str]:
    """Blocks from text such as "valve, hose".

    Raises:
        InputError: naming one that the bench does not have.
    """
    blocks = list(bench.default_blocks) if fitted is None else [part.strip() for part in fitted.split(",")]
    return check_known(blocks, bench.blocks, "--fit", "block")


def _part(folder: str, name: str):  # type: ignore[no-untyped-def]
    return import_module(f"{__package__}.{folder}.{name}")
