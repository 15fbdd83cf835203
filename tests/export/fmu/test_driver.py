"""FMUs in an importer in C: under sanitizers, and as Windows programs."""

import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from layflat.arrays import Array
from layflat.export.entries import ControlEntries
from layflat.export.fmu import libraries
from layflat.export.fmu.law_source import law_source
from layflat.export.fmu.model import FmuModel
from layflat.export.fmu.plant import PlantFunctions
from layflat.export.fmu.writer import LawCode
from layflat.machine import load
from layflat.sim.results import Run
from tests.export.fmu.runs import CYCLE, names_of, rows_of, run_of

pytestmark = pytest.mark.compiled

DRIVER = Path(__file__).parent / "driver.c"
OUTPUTS = ("angle", "velocity", "pressure_a", "voltage")


def driven(command: list[str], library: str, token: str, references: dict[str, int], run: Run) -> Array:
    """Return the rows that the driver writes of a run's demands."""
    inputs, outputs = ([references[name] for name in names] for names in (
        [*names_of("demand"), *(("payload",) if "payload" in references else ())],
        [name for signal in OUTPUTS for name in names_of(signal)],
    ))  # fmt: skip
    rows = [[*row, 1.5] for row in run["demand"].values[:-1].tolist()]
    lines = [[len(inputs), *inputs], [len(outputs), *outputs], [len(rows)], *rows]
    table = "\n".join(" ".join(map(repr, line)) for line in lines)
    done = subprocess.run(
        [*command, library, token, repr(CYCLE)], input=table, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, (done.returncode, done.stderr[-2000:])
    return np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])


def model_of_paper_arm() -> FmuModel:
    machine = load("paper-arm")
    return FmuModel(machine, PlantFunctions(machine), ControlEntries(machine, 8), True, True)


def expected(run: Run) -> Array:
    return rows_of(run, OUTPUTS).reshape(run.sizes["time"] - 1, -1)


def test_no_wrong_access_and_no_undefined_behaviour(compiler: str, tmp_path: Path) -> None:
    """An FMU whose parameters nobody sets has noise of seed 0."""
    checked = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O1", "-std=c11")
    tried = subprocess.run(
        [compiler, *checked, "-xc", "-", "-o", tmp_path / "tried"], input=b"int main(void){return 0;}", check=False
    )
    if tried.returncode:
        pytest.skip(f"{compiler} has no sanitizers here")
    model, system = model_of_paper_arm(), libraries.host_system()
    assert system is not None
    law = tmp_path / "law.c"
    law.write_text(law_source(model), encoding="utf-8")
    (tmp_path / "model.h").write_text(model.header("{token}"), encoding="utf-8")
    sources, folders = sorted(libraries.SOURCE_FOLDER.glob("*.c")), [f"-I{tmp_path}", f"-I{libraries.SOURCE_FOLDER}"]
    library, driver = tmp_path / "library.so", tmp_path / "driver"
    shared = [compiler, *checked, "-ffp-contract=off", "-fPIC", "-shared", *folders]
    subprocess.run([*map(str, [*shared, *sources, law, "-lm", "-o", library])], check=True)
    subprocess.run([*map(str, [compiler, *checked, DRIVER, "-ldl", "-o", driver])], check=True)
    run = run_of(True, 0)
    references = {variable.name: reference for reference, variable in model.variables}
    rows = driven([str(driver)], str(library), "{token}", references, run)
    assert np.array_equal(rows, expected(run))


def test_the_library_of_windows_repeats_the_run(tmp_path: Path) -> None:
    """Under Wine, if it is there."""
    wine = shutil.which("wine") or shutil.which("wine64") or ("" if sys.platform == "win32" else None)
    if wine is None or find_spec("ziglang") is None:
        pytest.skip("needs wine and ziglang")
    model = model_of_paper_arm()
    windows = next(system for system in libraries.LINKED_SYSTEMS if system.suffix == ".dll")
    zig = libraries.find_linker()
    linker = libraries.Linker(zig.title, zig.command, (windows,), cross=True)

    objects = LawCode(model, linker).by_system
    library = tmp_path / "arm.dll"
    library.write_bytes(
        libraries.link_libraries(linker, "2.0", model.header("{token}"), objects, tmp_path / "linked")[windows]
    )
    driver = tmp_path / "driver.exe"
    subprocess.run([*zig.command, "-target", windows.triple, "-O2", str(DRIVER), "-o", str(driver)], check=True)
    run = run_of(True, 0)
    references = {variable.name: reference for reference, variable in model.variables}
    path = f"Z:{library}" if wine else str(library)
    command = [word for word in (wine, str(driver)) if word]
    rows = driven(command, path, "{token}", references, run)
    assert np.array_equal(rows, expected(run))
