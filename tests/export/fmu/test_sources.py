"""C sources of FMUs: no warnings, the standard's own declarations, NumPy's noise, and no wrong access to memory."""

import ctypes
import shutil
import subprocess
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from layflat.export.entries import ControlEntries
from layflat.export.fmu.libraries import SOURCE_FOLDER
from layflat.export.fmu.model import FmuModel
from layflat.export.fmu.plant import PlantFunctions
from layflat.export.fmu.writer import FMU_SCOPES
from layflat.machine import load

WARNINGS = ("-std=c11", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")


@pytest.fixture(scope="module")
def headers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Folders of model.h by the part of the machine."""
    machine = load("paper-arm")
    plant, control = PlantFunctions(machine), ControlEntries(machine, 8)
    folders = {}
    for scope, (has_plant, has_control) in FMU_SCOPES.items():
        folder = folders[scope] = tmp_path_factory.mktemp("header")
        text = FmuModel(machine, plant, control, has_plant, has_control).header("{token}")
        (folder / "model.h").write_text(text, encoding="utf-8")
    return folders


def compiled(*words: object) -> None:
    done = subprocess.run([*map(str, words)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(("compiler", "scope"), [*product(("gcc", "clang"), FMU_SCOPES)])
def test_sources_compile_without_a_warning(headers: dict[str, Path], compiler: str, scope: str) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"needs {compiler}")
    for source in SOURCE_FOLDER.glob("*.c"):
        compiled(compiler, *WARNINGS, f"-I{headers[scope]}", "-fsyntax-only", source)


def test_declarations_are_those_of_the_standard(headers: dict[str, Path], compiler: str) -> None:
    """The standard's headers declare the same functions; a difference would not compile."""
    fmpy = pytest.importorskip("fmpy", reason="needs fmpy, whose package holds the headers of the standard")
    standard = Path(fmpy.__file__).parent / "c-code"
    for source in SOURCE_FOLDER.glob("fmi*.c"):
        compiled(compiler, "-std=c11", "-DFMI_HEADERS", f"-I{standard}", f"-I{headers['']}", "-fsyntax-only", source)


@pytest.mark.parametrize("seed", [0, 1, 7, 2**31 - 1])
def test_noise_is_that_of_numpy(headers: dict[str, Path], compiler: str, tmp_path: Path, seed: int) -> None:
    """Half a million samples, so that all branches are taken; the tail ends in the C library's logarithm."""
    library = tmp_path / "noise.so"
    compiled(
        compiler, "-std=c11", "-O2", "-ffp-contract=off", "-shared", "-fPIC", f"-I{headers['']}",
        SOURCE_FOLDER / "noise.c", "-lm", "-o", library,
    )  # fmt: skip
    noise, generator, count = ctypes.CDLL(str(library)), (ctypes.c_uint64 * 4)(), 500_000
    noise.noise_normal.restype = ctypes.c_double
    noise.noise_seed(generator, ctypes.c_uint32(seed))
    samples = np.array([noise.noise_normal(generator) for _ in range(count)])
    expected = np.random.default_rng(seed).standard_normal(count)
    assert np.allclose(samples, expected, rtol=1e-14, atol=0.0)
    inside = np.abs(expected) < 3.65
    assert np.array_equal(samples[inside], expected[inside])
    assert (~inside).sum() > 50
