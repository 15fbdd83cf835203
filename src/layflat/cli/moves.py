"""How well demands were followed, as a table; of simulated and of recorded runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import typer

from layflat.cli.app import print_table

if TYPE_CHECKING:
    import xarray

    from layflat.sim.metrics import Move


def print_moves(moves: Sequence[tuple[float, Move]], name: str) -> None:
    """Metrics of moves, with the times from which they count."""
    rows = [
        [f"{since:g}", m.joint, _seconds(m.settling), *(f"{57.29578 * x:.3f}" for x in (m.overshoot, m.steady_error))]
        for since, m in moves
    ]
    columns = ["from (s)", "joint", "settling (s)", "overshoot (deg)", "steady error (deg)"]
    print_table(columns, rows, f"{name}: moves, settled within 0.3 deg")


def print_missed(run: xarray.Dataset, what: str) -> None:
    """How far a run was from demands that change all the time."""
    missed = 57.29578 * ((run["angle"] - run["demand"]) ** 2).mean("time") ** 0.5
    told = ", ".join(f"{name} {missed.sel(joint=name).item():.2f} deg" for name in run["joint"].values)
    typer.echo(f"rms error against {what}: {told}")


def _seconds(value: float) -> str:
    return f"{value:.3f}" if value < 1e6 else "not settled"
