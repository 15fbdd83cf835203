"""The folder of readable C as a reviewer has it: compiled by the compilers that are there, run, and read."""

import re
import subprocess
from pathlib import Path

import pytest

from layflat.control.paper.law import step_joint
from layflat.export import export
from layflat.machine import load
from tests.export.builds import needing, run
from tests.export.c_source.programs import different_cycles, last_line_of_example
from tests.export.firmware.boards import WHOLE_CHECK
from tests.test_outside_kinds import COMPILED, outside_machine

COMPILERS = ("gcc", "clang")
FORBIDDEN = (
    r"\bgoto\b|\bmalloc\b|\bcalloc\b|\bfree\(|\(\*\w+\)\(|\bstatic (?!const )\w+ \w+ =|\bstatic (?!const )\w+ \w+;"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("exported") / "c-source"
    assert export("paper-arm", "c-source", path)
    return path


@pytest.mark.parametrize("compiler", COMPILERS)
def test_strict_compilers_and_sanitizers_have_nothing_to_say(folder: Path, compiler: str) -> None:
    assert last_line_of_example(folder, compiler) == "0 of 400 cycles differ from the recording"


def test_make_builds_and_compares(folder: Path) -> None:
    needing("make")
    done = subprocess.run(["make", "run"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert done.stderr == ""
    assert done.stdout.splitlines()[-1].startswith("0 of ")


def test_cmake_builds_and_compares(folder: Path) -> None:
    run([needing("cmake"), "-S", ".", "-B", "built"], folder)
    run(["cmake", "--build", "built"], folder)
    assert run(["./built/example"], folder).splitlines()[-1].startswith("0 of ")


@pytest.mark.parametrize("compiler", COMPILERS)
def test_all_numbers_are_those_of_the_host(folder: Path, compiler: str) -> None:
    assert list(different_cycles(load("paper-arm"), folder, "double", compiler)) == []


def test_all_numbers_of_a_kind_from_outside_are_those_of_the_host(tmp_path: Path) -> None:
    machine = load(outside_machine(tmp_path, COMPILED))
    export(machine, "c-source", tmp_path / "out")
    assert list(different_cycles(machine, tmp_path / "out", "double", "gcc")) == []


def test_single_precision_is_that_of_the_host(tmp_path: Path) -> None:
    export("paper-arm", "c-source", tmp_path / "out", precision="single")
    assert list(different_cycles(load("paper-arm"), tmp_path / "out", "single", "gcc")) == []


@WHOLE_CHECK
@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("name", ["paper-arm-tracking", "picking-arm", "single-joint-lift"])
def test_all_numbers_of_laws_with_a_model_are_those_of_the_host(tmp_path: Path, name: str, precision: str) -> None:
    export(name, "c-source", tmp_path / "out", precision=precision)
    for compiler in COMPILERS:
        assert list(different_cycles(load(name), tmp_path / "out", precision, compiler)) == []


def test_the_law_reads_as_one(folder: Path) -> None:
    """Names, descriptions and units are the law's; lines fit; nothing is there that reviewers forbid."""
    text = (folder / "paper_arm.c").read_text()
    assert f"/* {str(step_joint.__doc__).splitlines()[0]}\n" in text
    assert "layflat/control/paper/law.py" in text
    assert "| k_e, k_p | gains of the present phase | V/rad, V/Pa |" in text
    assert "    const double x_mean = mean4(x, memory->angle_0, memory->angle_1, memory->angle_2);\n" in text
    assert max(map(len, text.splitlines())) <= 120
    assert re.search(FORBIDDEN, text) is None


def test_the_same_machine_gives_the_same_text(folder: Path, tmp_path: Path) -> None:
    export("paper-arm", "c-source", tmp_path / "again")
    for path in (tmp_path / "again").iterdir():
        assert path.read_bytes() == (folder / path.name).read_bytes()
