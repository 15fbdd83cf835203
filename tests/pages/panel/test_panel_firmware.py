"""The panel drives a microcontroller's firmware on a simulated board, with a virtual rig as sensors and valves."""

import re
from pathlib import Path

import pytest

from layflat.machine import load
from tests.export.firmware.controllers import Firmware
from tests.export.firmware.served import PATIENCE, board_on_plant
from tests.pages.browsers import PATIENT, served
from tests.pages.panel.arm import obeys
from tests.pages.visitor import Visitor

pytestmark = pytest.mark.realtime
DESCRIPTION = "\n".join([
    'extends = "paper-arm-tracking"', 'name = "patient-arm"',
    *(f"{path} = {value if isinstance(value, int) else repr(f'{value} s')}" for path, value in PATIENCE.items()),
])  # fmt: skip
TARGET, TOLERANCE = [20.0, -15.0], 1.0  # deg
STARTS, MOVES = 60.0, 40.0  # upper limits on a busy computer, s


def angles(visitor: Visitor) -> list[float]:
    """Return the joints' angles as the page shows them, degrees."""
    texts = [str(one["text"]) for _, one in visitor.each() if "lf-number" in one.get("class", [])]
    return [float(number[1]) for text in texts if (number := re.match(r"(-?[\d.]+) deg, target", text))]


def go_to(visitor: Visitor, target: list[float]) -> None:
    """Press "Go to target" with these angles in its fields, degrees."""
    visitor.until(lambda: obeys(visitor), STARTS)
    for joint, angle in zip(("large", "small"), target, strict=True):
        visitor.enter(f"{joint} (deg)", f"{angle:g}")
    visitor.until(lambda: visitor.enabled("Go to target"))
    visitor.press("Go to target")


def test_the_panel_starts_moves_and_stops_the_firmware(tmp_path: Path) -> None:
    (tmp_path / "arm.toml").write_text(DESCRIPTION, encoding="utf-8")
    machine, folder = load(tmp_path / "arm.toml"), tmp_path / "firmware"
    folder.mkdir()
    with (
        board_on_plant(machine, Firmware(machine), "cortex-m7", folder) as board,
        served(tmp_path, "panel", "arm.toml", "--driver", board.address, before=PATIENT) as found,
        Visitor(found.link) as visitor,
    ):
        visitor.until(lambda: visitor.text_of("lf-state") == "Off", STARTS)
        go_to(visitor, TARGET)
        visitor.until(lambda: max(abs(a - b) for a, b in zip(angles(visitor), TARGET, strict=True)) < TOLERANCE, MOVES)
        go_to(visitor, [-angle for angle in TARGET])
        visitor.until(lambda: visitor.text_of("lf-state") == "Moving")
        visitor.press("Stop")
        visitor.until(lambda: visitor.text_of("lf-state") == "Holding")
        board.tell("fail e-stop")
        visitor.until(lambda: visitor.text_of("lf-state") == "Fault")
