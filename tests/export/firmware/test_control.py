"""Control laws on microcontrollers compute this computer's numbers, within their flash, RAM and time."""

from pathlib import Path

import numpy as np
import pytest

from layflat.machine import load
from tests.export.firmware.boards import BOARDS, WHOLE_CHECK, require_tools
from tests.export.firmware.recordings import HostLaw, Recording, interpreted_results, record_closed_loop
from tests.export.firmware.replays import replay

CYCLES = 400  # 2 s
FLASH, RAM = 128 * 1024, 16 * 1024  # of a small microcontroller, bytes
INSTRUCTIONS = {"paper-arm": 600, "paper-arm-tracking": 25_000}  # upper limits of a cycle
EMULATED_INSTRUCTIONS = 15_000  # of the paper's law, where double precision is emulated
CASES = [
    pytest.param("paper-arm", "cortex-m7", "double"),
    pytest.param("paper-arm", "cortex-m4f", "single"),
    pytest.param("paper-arm", "cortex-m4f", "double"),
    pytest.param("paper-arm", "cortex-m33", "single"),
    pytest.param("paper-arm", "riscv32", "double"),
    pytest.param("paper-arm-tracking", "cortex-m7", "double", marks=WHOLE_CHECK),
    pytest.param("paper-arm-tracking", "cortex-m4f", "single", marks=WHOLE_CHECK),
]

Laws = dict[object, tuple[HostLaw, Recording]]


@pytest.fixture(scope="module")
def laws() -> Laws:
    """Laws and recordings by machine and precision, each made once."""
    return {}


def law_of(laws: Laws, name: str, precision: str) -> tuple[HostLaw, Recording]:
    if (name, precision) not in laws:
        machine = load(name)
        laws[name, precision] = HostLaw(machine, precision), record_closed_loop(machine, CYCLES)
    return laws[name, precision]


@pytest.mark.parametrize(("name", "target", "precision"), CASES)
def test_a_law_on_a_board_computes_the_numbers_of_this_computer(
    laws: Laws, name: str, target: str, precision: str, tmp_path: Path
) -> None:
    require_tools(BOARDS[target].example.tools)
    law, recording = law_of(laws, name, precision)
    expected = interpreted_results(law.machine, recording) if precision == "double" else law.results(recording)
    voltages = expected[:, law.voltages]
    assert np.ptp(voltages, axis=0).min() > 1.0, "the law has something to do"
    done = replay(law, recording, target, BOARDS[target], tmp_path)
    np.testing.assert_array_equal(done.results, expected)
    emulated = precision == "double" and target == "cortex-m4f"
    assert done.instructions.max() <= (EMULATED_INSTRUCTIONS if emulated else INSTRUCTIONS[name])
    assert done.flash <= FLASH
    assert done.ram <= RAM


def test_single_precision_differs_by_millivolts(laws: Laws) -> None:
    law, recording = law_of(laws, "paper-arm", "single")
    exact = interpreted_results(law.machine, recording)[:, law.voltages]
    error = np.abs(law.results(recording)[:, law.voltages] - exact)
    assert 0.0 < error.max() < 5e-3
