"""Does anything move? What does not move more than its noise identifies nothing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from layflat.identify.logs.checks.channels import Channel, CheckedLog, noise
from layflat.identify.logs.issue import Issue

STILL = 6.0
"""Range in standard deviations of the noise below which a signal does not move."""

NOTHING_MOVES = Issue("error", "log", "nothing in it moves more than its noise", "record a motion")

STEADY = ("supply", "payload", "brake")
"""What is usually constant."""


def issues(log: CheckedLog) -> Iterator[Issue]:
    """Signals and commands that stand still."""
    measured = [c for c in log.filled if not c.signal.held and c.signal.name not in STEADY]
    still = [channel for channel in measured if not moves(channel)]
    if measured and len(still) == len(measured):
        yield NOTHING_MOVES
        return
    for channel in still:
        if np.ptp(channel.known) == 0.0:
            continue  # said to be dead
        text = f"moves no more than its noise, about {channel.shown(channel.high)}"
        driven = channel.signal.name in {"angle", "position", "force"}
        yield Issue("warning" if driven else "note", channel.name, text, "nothing is identifiable from it")
    commands = [c for c in log.filled if c.signal.held and c.signal.name not in STEADY]
    for joint in dict.fromkeys(channel.joint for channel in commands):
        mine = [channel for channel in commands if channel.joint == joint]
        if all(np.ptp(channel.known) == 0.0 for channel in mine):
            names = " and ".join(channel.name for channel in mine)
            yield Issue("warning", mine[0].name, f"{names} never change", "command a motion: steps, sweeps or noise")


def moves(channel: Channel) -> bool:
    """Whether a signal moves by more than its noise."""
    known = channel.known
    span = float(np.percentile(known, 99.0) - np.percentile(known, 1.0))
    return span > STILL * noise(known)
