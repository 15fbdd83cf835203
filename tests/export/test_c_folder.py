"""The folder of C as its user has it: compiled by every compiler that is there, and run."""

import ctypes
from pathlib import Path

import numpy as np
import pytest

from layflat.arrays import Array
from layflat.export import export
from layflat.export.boards import EXAMPLE_BOARDS
from layflat.machine import load
from layflat.sim import Scenario
from layflat.sim.run import prepare_run
from tests.export.builds import (
    LANGUAGES,
    LEVELS,
    SANITIZED,
    STRICT,
    build,
    needing,
    read_trace,
    run,
    run_board,
    target_runs_here,
)
from tests.export.firmware.folders import check_firmware
from tests.export.loops import jit_voltages, python_trace
from tests.rig.devices import patient

TABLES = ("parameters", "settings")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("exported") / "c"
    assert export("paper-arm", "c", path)
    return path


@pytest.fixture(scope="module")
def trace() -> Array:
    return python_trace(load("paper-arm"))


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_example_prints_what_python_computes(folder: Path, trace: Array, compiler: str, language: str) -> None:
    """Strict compilers have nothing to say, sanitizers neither, and every number of 2 s is the same to the bit."""
    program = build(folder, needing(compiler), *LANGUAGES[language], *STRICT, *SANITIZED)
    printed = read_trace(run([program], folder))
    assert np.ptp(trace[:, 1]) > np.radians(10.0)  # it moves
    assert np.array_equal(printed[:, 1:], trace[:, 1:])


@pytest.mark.parametrize("target", LEVELS)
def test_every_level_of_x86_64_computes_the_same(folder: Path, trace: Array, target: str) -> None:
    if not target_runs_here(target):
        pytest.skip(f"this computer does not run {target}")
    program = build(folder, needing("gcc"), *LANGUAGES["C"], *STRICT, target=target)
    assert np.array_equal(read_trace(run([program], folder))[:, 1:], trace[:, 1:])


def test_a_64_bit_arm_computes_the_same(folder: Path, trace: Array) -> None:
    needing("qemu-aarch64")
    program = build(
        folder, needing("aarch64-linux-gnu-gcc"), *LANGUAGES["C"], *STRICT, "-static", target="linux-aarch64"
    )
    printed = run(["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu", program], folder)
    assert np.array_equal(read_trace(printed)[:, 1:], trace[:, 1:])


def test_make_builds_and_runs_the_example(folder: Path, trace: Array) -> None:
    printed = run([needing("make"), "-s", "run"], folder)
    assert np.array_equal(read_trace(printed)[:, 1:], trace[:, 1:])


def test_cmake_builds_the_example(folder: Path, trace: Array) -> None:
    run([needing("cmake"), "-S", ".", "-B", "built"], folder)
    run(["cmake", "--build", "built"], folder)
    assert np.array_equal(read_trace(run(["./built/example"], folder))[:, 1:], trace[:, 1:])


def test_machines_run_side_by_side_and_are_saved_and_restored(folder: Path) -> None:
    source = str(Path(__file__).with_name("side_by_side.c"))
    program = build(folder, needing("gcc"), *LANGUAGES["C"], *STRICT, *SANITIZED, source=source)
    assert run([program], folder) == "as it must be\n"


def test_a_run_in_one_call_is_a_rollout(folder: Path) -> None:
    """Record by record, to the bit, with two records a cycle."""
    machine = load("paper-arm")
    scenario = Scenario(demand=[("0 s", "0 deg"), ("0.1 s", "12 deg")], duration="0.5 s", load=[("0.2 s", 1.0)], seed=3)
    prepared = prepare_run(machine, scenario, records=2)
    rows, report, diverged = prepared.run()
    objects = sorted(map(str, (folder / "lib" / "linux-x86-64").iterdir()))
    run([needing("gcc"), "-shared", "-fPIC", "-o", "run.so", "paper_arm.c", *objects], folder)
    library = ctypes.CDLL(str(folder / "run.so"))
    tables = [ctypes.addressof(ctypes.c_char.in_dll(library, f"paper_arm_default_{name}")) for name in TABLES]
    pressures = np.ascontiguousarray(prepared.pressures.T)
    records, reports, counts = np.zeros_like(rows), np.zeros_like(report), np.zeros(3, np.int64)
    signals = prepared.signals
    inputs = (prepared.angles, pressures, signals.by_joint, signals.shared, prepared.samples)
    addresses = [ctypes.c_void_p(one) for one in (*tables, *(array.ctypes.data for array in inputs))]
    outputs = [ctypes.c_void_p(array.ctypes.data) for array in (records, reports, counts)]
    assert library.paper_arm_run(*addresses, len(signals.by_joint), 2, *outputs) == diverged == -1
    assert counts.tolist() == [99, len(rows), -1]
    assert np.ptp(rows[:, :, 0]) > np.radians(3.0)
    assert np.array_equal(records, rows)
    assert np.array_equal(reports, report)


def test_single_precision_is_the_same_as_on_the_host(tmp_path: Path) -> None:
    """The example compares with the host's object, and that is the same as what numba's own compiler makes."""
    export("paper-arm", "c", tmp_path / "c", precision="single")
    program = build(tmp_path / "c", needing("gcc"), *LANGUAGES["C"], *STRICT, *SANITIZED)
    *printed, last = run([program], tmp_path / "c").splitlines()
    assert last == "0 of 400 cycles differ from the recording"
    voltages = np.array([list(map(float, line.split(","))) for line in printed])
    assert np.array_equal(voltages.astype(np.float32), jit_voltages(load("paper-arm")))


@pytest.mark.parametrize(
    ("target", "precision"),
    [("cortex-m7", "double"), ("cortex-m4f", "single"), ("cortex-m33", "single"), ("riscv32", "double")],
)
def test_a_microcontroller_computes_the_same(target: str, precision: str, tmp_path: Path) -> None:
    compiler, emulator = EXAMPLE_BOARDS[target].tools
    needing(compiler)
    export("paper-arm", target, tmp_path / target, precision=precision)
    last = run_board(tmp_path / target, compiler, emulator)
    assert last == "0 of 400 cycles differ from the recording"
    check_firmware(tmp_path / target / "firmware", patient(load("paper-arm")))
