"""Machine code as files: found, kept, and never believed when it is damaged, of other sources or another processor."""

import ast
import logging
import os
import subprocess
import sys
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from layflat import registers
from layflat.jit import functions, stored
from layflat.jit.cache import PACKAGE_FOLDER, WITHOUT_LAWS, imported_files, source_digest
from layflat.jit.functions import PortableKernel
from layflat.jit.objects import Processor, host, machine_code
from layflat.jit.signatures import UnportableError

OTHER_PROCESSOR = Processor(
    "x86_64-unknown-linux-gnu" if "aarch64" in host().triple else "aarch64-unknown-linux-gnu", "generic"
)

KERNEL_FILE = """
import sys
import numpy as np
from layflat.jit import portable_kernel

@portable_kernel(results=1)
def add_up(numbers, factor):
    total = 0.0
    for i in range(len(numbers)):
        total += factor * numbers[i]
    numbers[0] = total
    return len(numbers)

values = np.arange(4.0)
print(add_up(values, 2.0), values[0], "numba" in sys.modules)
"""


def add_up(numbers: Any, factor: Any) -> Any:
    total = 0.0
    for i in range(len(numbers)):
        total += factor * numbers[i]
    numbers[0] = total


@pytest.fixture
def kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> PortableKernel:
    """A kernel that nothing was compiled of, with a cache of its own and no prebuilt code."""
    if registers.interpreted():
        pytest.skip("nothing is compiled")
    monkeypatch.setenv("LAYFLAT_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(stored, "PREBUILT_FOLDER", tmp_path / "prebuilt")
    monkeypatch.setattr(stored, "_remarked", [])
    return PortableKernel(add_up, 0)


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """LLVM's texts of the kernels that the test compiles."""
    texts: list[str] = []
    monkeypatch.setattr(functions, "COMPILATION_OBSERVERS", [lambda _kernel, _args, text: texts.append(text)])
    return texts


def total(kernel: PortableKernel) -> float:
    """The sum of 0, 2, 4, 6 by a kernel that has loaded nothing yet."""
    numbers: NDArray[np.float64] = np.arange(4.0)
    PortableKernel(kernel.py_func, 0)(numbers, 2.0)
    return float(numbers[0])


def cached(tmp_path: Path) -> Path:
    (path,) = (tmp_path / "cache").rglob("*.o")
    return path


def write_prebuilt(tmp_path: Path, kernel: PortableKernel, text: str, processor: Processor | None = None) -> Path:
    path = tmp_path / "prebuilt" / stored.host_levels()[0] / kernel.code_name((np.arange(4.0), 2.0))
    path.parent.mkdir(parents=True, exist_ok=True)
    stored.write_code(path, machine_code(text, ("add_up",), processor or host()))
    return path


def test_imports_are_found_as_python_finds_them() -> None:
    for path in PACKAGE_FOLDER.rglob("*.py"):
        assert imported_files(str(path)) == set(parsed_imports(path)), path


def parsed_imports(path: Path) -> Iterator[str]:
    """The files of the package with laws that a file imports at module level, by Python's own parser."""
    for statement in ast.parse(path.read_bytes()).body:
        names = []
        if isinstance(statement, ast.Import):
            names = [alias.name for alias in statement.names]
        elif isinstance(statement, ast.ImportFrom) and statement.module and not statement.level:
            names = [statement.module, *(f"{statement.module}.{alias.name}" for alias in statement.names)]
        for package, *steps in (name.split(".") for name in names):
            place = PACKAGE_FOLDER.joinpath(*steps)
            if package == "layflat" and steps and not {steps[0], f"{steps[0]}.py"} & set(WITHOUT_LAWS):
                yield from (str(file) for file in (place.with_suffix(".py"), place / "__init__.py") if file.is_file())


@pytest.mark.parametrize(
    ("line", "file"),
    [
        ("from layflat.physics import hose", "physics/hose.py"),
        ("from layflat.physics import (  # a ) in a comment\n    hose as tube,\n)", "physics/hose.py"),
        ("from layflat import jit, lanes", "lanes.py"),
        ("import layflat.physics.hose as tube, os", "physics/hose.py"),
        ("import os, layflat.physics.hose", "physics/hose.py"),
    ],
)
def test_imports_of_any_form_are_found(line: str, file: str, tmp_path: Path) -> None:
    path = tmp_path / "kernels.py"
    path.write_text(f"import os\n{line}\n")
    assert str(PACKAGE_FOLDER / file) in imported_files(str(path))


def test_a_second_process_loads_without_the_compiler(tmp_path: Path) -> None:
    script = tmp_path / "kernels.py"
    script.write_text(KERNEL_FILE)
    environment = {**os.environ, "LAYFLAT_CACHE_DIR": str(tmp_path / "cache"), "LAYFLAT_VERBOSE": "1"}
    environment.pop("NUMBA_DISABLE_JIT", None)
    first, second = (
        subprocess.run([sys.executable, script], env=environment, capture_output=True, text=True, check=True)
        for _ in range(2)
    )
    assert first.stdout == "4 12.0 True\n"
    assert first.stderr.startswith("compiling add_up of kernels.py: ")
    assert (second.stdout, second.stderr) == ("4 12.0 False\n", "")


def test_a_damaged_file_is_compiled_anew_and_remarked_once(
    tmp_path: Path, kernel: PortableKernel, compiled: list[str], caplog: pytest.LogCaptureFixture
) -> None:
    assert total(kernel) == 12.0
    path = cached(tmp_path)
    content = path.read_bytes()
    write_prebuilt(tmp_path, kernel, compiled[0]).write_bytes(content[:-1] + b"x")
    for damaged in (content[:-1] + b"x", content[:100], b""):
        path.write_bytes(damaged)
        assert total(kernel) == 12.0
        assert path.read_bytes() == content
    assert len(compiled) == 4
    (remark,) = (record for record in caplog.records if record.levelno >= logging.WARNING)
    assert "is damaged: its kernel is compiled instead" in remark.getMessage()


def test_machine_code_of_another_processor_is_not_loaded(
    tmp_path: Path, kernel: PortableKernel, compiled: list[str], caplog: pytest.LogCaptureFixture
) -> None:
    assert total(kernel) == 12.0
    write_prebuilt(tmp_path, kernel, compiled[0], OTHER_PROCESSOR)
    assert total(kernel) == 12.0
    assert len(compiled) == 1  # that of the cache is found
    assert "is of another processor" in caplog.records[-1].getMessage()


def test_prebuilt_machine_code_comes_first(tmp_path: Path, kernel: PortableKernel, compiled: list[str]) -> None:
    assert total(kernel) == 12.0
    write_prebuilt(tmp_path, kernel, compiled[0].replace("fmul", "fadd"))
    assert total(kernel) == 14.0
    assert len(compiled) == 1


def test_code_of_every_level_of_this_computer_has_the_same_bits(
    tmp_path: Path, kernel: PortableKernel, compiled: list[str]
) -> None:
    numbers = np.random.default_rng(3).normal(size=(4, 1001)) ** 3
    expected = numbers.copy()
    kernel(expected[0], 0.1)
    names = {"linux-x86-64-v2": "x86-64-v2", "linux-x86-64-v3": "x86-64-v3", "linux-x86-64-v4": "x86-64-v4"}
    for level in stored.host_levels():
        write_prebuilt(tmp_path, kernel, compiled[0], Processor(host().triple, names.get(level, "generic")))
        again = numbers.copy()
        PortableKernel(add_up, 0)(again[0], 0.1)
        assert again.tobytes() == expected.tobytes()
    assert len(compiled) == 1


def test_names_differ_with_sources_types_and_the_width_of_lanes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wide, narrow = PortableKernel(add_up, 0, in_lanes=True), PortableKernel(add_up, 0)
    by_size = {}
    for size in (32, 64):
        monkeypatch.setattr(registers, "_register_bytes", [size])
        by_size[size] = wide.code_name((1.0,)), narrow.code_name((1.0,))
    assert by_size[32][0] != by_size[64][0]
    assert by_size[32][1] == by_size[64][1]
    signatures = [(1.0,), (1,), (np.zeros(2), 1.0), (np.zeros((2, 2)), 1.0), (np.zeros(2, np.float32), 1.0)]
    assert len({narrow.code_name(args) for args in signatures}) == len(signatures)
    other = tmp_path / "other.py"
    other.write_text("")
    assert stored.code_name(other, "add_up", "f") != stored.code_name(Path(__file__), "add_up", "f")


def test_arguments_without_words_are_refused() -> None:
    for arg in (np.zeros((2, 2)).T, "text", None):
        with pytest.raises(UnportableError):
            PortableKernel(add_up, 0).code_name((arg,))


def test_the_reason_of_a_compilation_is_what_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, level = PACKAGE_FOLDER / "sim" / "tally.py", stored.host_levels()[0]
    monkeypatch.setattr(stored, "PREBUILT_FOLDER", tmp_path)
    assert "for this processor is installed" in stored.missing_reason(file)
    (tmp_path / level).mkdir()
    assert "its file has no prebuilt" in stored.missing_reason(file)
    source = tmp_path / stored.SOURCES_FOLDER / stored.source_name(file)
    source.parent.mkdir()
    source.write_text(sha256(b"").hexdigest()[:16])
    assert "of other sources" in stored.missing_reason(file)
    assert stored.find_stale_sources() == ["sim-tally.py"]
    source.write_text(source_digest(file))
    assert "types of arguments" in stored.missing_reason(file)
    assert stored.find_stale_sources() == []
    monkeypatch.setattr(stored, "included_sources", lambda: ("0",))
    assert "from outside the package" in stored.missing_reason(file)
