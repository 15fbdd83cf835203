"""Pictures of an arm, and its page in the browser, for environments."""

import time
from typing import TYPE_CHECKING

import numpy as np

from layflat.arrays import Array, Picture
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.machine import Machine

if TYPE_CHECKING:
    from layflat.bridge.view.browser import Viewer

RENDER_MODES = ("rgb_array", "human")


def check_render_mode(mode: str | None) -> str | None:
    """Return a mode of rendering; raise InputError if there is no such mode."""
    if mode is not None and mode not in RENDER_MODES:
        raise InputError(f"{shown(mode)} is unknown", where="render_mode", right=f"use {' or '.join(RENDER_MODES)}")
    return mode


class ArmRenderer:
    """Pictures of a machine's arm, or a page that shows it in the pace of its motion.

    Args:
        machine: the machine.
        mode: one of `RENDER_MODES`.

    Attributes:
        address: address of the page; empty for pictures.

    Raises:
        InputError: the arm is of a kind without bodies.
        MissingExtraError: the extra `view` is not installed.
    """

    def __init__(self, machine: Machine, mode: str) -> None:
        from layflat.bridge.view.scenery import scenery  # noqa: PLC0415

        middle = [0.0] * len(machine.joints)
        self._scenery = scenery(machine, middle)
        self._viewer = _open_viewer(machine, middle) if mode == "human" else None
        self.address = "" if self._viewer is None else self._viewer.address
        self._shown = time.monotonic()

    def show(self, angles: Array, period: float) -> None:
        """Show angles (rad) on the page, a period (s) after those of before; nothing without a page."""
        if self._viewer is None:
            return
        time.sleep(max(self._shown + period - time.monotonic(), 0.0))
        self._shown = time.monotonic()
        self._viewer.show_angles(angles)

    def picture(self, angles: Array) -> Picture:
        """Return the picture of the arm at angles (rad), RGB in uint8, (height, width, 3)."""
        from layflat.bridge.view.picture import render_picture  # noqa: PLC0415

        return render_picture(self._scenery, np.asarray(angles, float).tolist())

    def close(self) -> None:
        """End the page."""
        if self._viewer is not None:
            self._viewer.close()


def _open_viewer(machine: Machine, angles: list[float]) -> "Viewer":
    """Return the page of a machine at angles, rad, at any port that is free."""
    from layflat.bridge.view.browser import Viewer  # noqa: PLC0415

    return Viewer(machine, angles, port=0)
