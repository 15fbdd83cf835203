"""The sheet of a first start has the checks of a rig, in their order, with the limits at which they fail."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import numpy as np
import pytest

from layflat.errors import MachineError
from layflat.machine import Machine, load, names
from layflat.rig.check import _check_angle, _check_pressure, check_rig
from layflat.rig.clock import VirtualClock
from layflat.rig.device.virtual import SimulatedDriver
from layflat.rig.open_loop import OpenLoopRig
from layflat.solids.documents.commissioning import (
    SheetRow,
    commissioning_sheet,
    rows_by_hand,
    rows_with_air,
    rows_without_air,
)
from layflat.virtual_rig import VirtualRig
from tests.solids.documents.machines import with_joints

MACHINES = [name for name in names() if load(name).controller is not None]


def driver_of(machine: Machine) -> tuple[SimulatedDriver, VirtualClock]:
    clock = VirtualClock()
    return SimulatedDriver(VirtualRig(machine)(clock)), clock


def test_the_checks_are_those_of_a_rig_in_their_order_and_a_sound_rig_passes_them() -> None:
    machine = load("paper-arm")
    driver, clock = driver_of(machine)
    results = check_rig(machine, driver, clock, air=True)
    rows = rows_without_air(machine) + rows_with_air(machine)
    assert [row.check for row in rows] == [result.what for result in results]
    assert all(result.has_passed for result in results)
    assert rows[0].expected == results[0].finding


def numbers(text: str) -> list[float]:
    return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", text)]


@pytest.mark.parametrize("name", ["paper-arm", "picking-arm", "single-joint-lift"])
def test_a_reading_just_inside_the_expected_range_passes_and_just_outside_fails(name: str) -> None:
    machine = load(name)
    driver, clock = driver_of(machine)
    driver.configure()
    bench = OpenLoopRig(machine, driver, clock)
    rows = {row.check: row.expected for row in rows_without_air(machine)}
    rng = np.random.default_rng(1)
    for j, joint in enumerate(machine.joints):
        low, high, *noise = numbers(rows[f"angle of {joint}"])
        assert machine.angle_sensor is not None
        quiet = machine.angle_sensor.noise * rng.standard_normal(400)
        quiet -= np.median(quiet)
        for end in (low, high):
            inside, outside = np.radians(0.995 * end), np.radians(1.01 * end)
            assert _check_angle(bench, j, joint, inside + quiet).has_passed
            assert not _check_angle(bench, j, joint, outside + quiet).has_passed
        lsb = machine.angle_sensor.range / 2**machine.angle_sensor.bits
        white = rng.standard_normal(20000)
        white /= white.std()
        assert _check_angle(bench, j, joint, 0.9 * noise[-1] * lsb * white).has_passed
        assert not _check_angle(bench, j, joint, 1.15 * noise[-1] * lsb * white).has_passed
        if "at most" not in rows[f"angle of {joint}"]:
            assert not _check_angle(bench, j, joint, 0.85 * noise[0] * lsb * white).has_passed
        _, bar, *_ = numbers(rows[f"pressure of {joint}"])
        assert machine.pressure_sensor is not None
        quiet = machine.pressure_sensor.noise * rng.standard_normal(400)
        quiet -= np.median(quiet)
        assert _check_pressure(bench, j, joint, 0.99e5 * bar + quiet).has_passed
        assert not _check_pressure(bench, j, joint, 1.01e5 * bar + quiet).has_passed


def test_voltages_by_hand_are_those_of_the_described_ranges() -> None:
    rows = {row.check: row for row in rows_by_hand(load("paper-arm"))}
    middle, _, stop, _ = numbers(rows["angle of large"].expected)
    assert [middle, stop] == pytest.approx([1.65, 1.65 + 3.3 * 70.0 / 150.0], abs=5e-3)
    assert numbers(rows["valve of large"].expected) == [10.0, 0.05]  # it vents the hoses
    assert numbers({row.check: row for row in rows_by_hand(load("picking-arm"))}["valve of base"].expected)[0] == 5.0
    assert numbers(rows["regulator"].expected) == [4.0, 3.2, 5.0]


class Table(HTMLParser):
    """Texts of the rows of a page's tables."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.open = 0
        self.feed(text)

    def handle_starttag(self, tag: str, _: list[tuple[str, str | None]]) -> None:
        self.open += tag not in {"meta", "br"}
        if tag == "tr":
            self.rows.append([])
        elif tag in {"td", "th"}:
            self.rows[-1].append("")

    def handle_endtag(self, _: str) -> None:
        self.open -= 1

    def handle_data(self, data: str) -> None:
        if self.rows and self.rows[-1]:
            self.rows[-1][-1] += data.strip()


@pytest.mark.parametrize("name", [*MACHINES, "five"])
def test_the_page_has_a_field_for_every_check(name: str) -> None:
    machine = with_joints(5) if name == "five" else load(name)
    table = Table(commissioning_sheet(machine))
    assert table.open == 0
    rows: list[SheetRow] = [*rows_by_hand(machine), *rows_without_air(machine), *rows_with_air(machine)]
    shown = [row for row in table.rows if re.fullmatch(r"[ABC]\d+", row[0])]
    assert [tuple(row[1:4]) for row in shown] == [tuple(row) for row in rows]
    assert all(row[4] == "" for row in shown)


def test_the_commands_of_both_checks_stand_on_the_page() -> None:
    page = commissioning_sheet(load("paper-arm"))
    command = "layflat rig check paper-arm --driver serial:///dev/ttyACM0"
    assert f"<code>{command}</code>" in page
    assert f"<code>{command} --air</code>" in page


def test_a_rig_without_valves_is_refused() -> None:
    with pytest.raises(MachineError, match="has no valve or sensors"):
        commissioning_sheet(load("rig-kevlar"))
