"""Machine code that commands keep, show and remove; and short commands, which load no more than they need."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from layflat.jit import stored
from tests.cli.commands import layflat

DIGEST = "0123456789abcdef"
HEAVY = ("numba", "dask", "distributed", "pyarrow")

COMMAND = """
import sys
from layflat.cli import main
try:
    main()
finally:
    print(*(name for name in {heavy!r} if name in sys.modules), file=sys.stderr)
"""


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache with a kernel of these sources, and a file that is none of layflat's."""
    root = tmp_path / "cache"
    (root / DIGEST).mkdir(parents=True)
    (root / DIGEST / "kernel.o").write_bytes(bytes(1_500_000))
    (root / "mine.txt").write_text("kept")
    monkeypatch.setenv("LAYFLAT_CACHE_DIR", str(root))
    return root


def run_twice(folder: Path, *words: str) -> list[str]:
    """What the same command prints on stderr, its heavy modules last, when it compiles and when it need not."""
    environment = {**os.environ, "LAYFLAT_STATE_DIR": str(folder / "state")}
    environment.pop("NUMBA_DISABLE_JIT", None)
    program = [sys.executable, "-c", COMMAND.format(heavy=HEAVY), *words]
    return [
        subprocess.run(program, env=environment, cwd=folder, capture_output=True, text=True, check=True).stderr
        for _ in range(2)
    ]


def test_the_cache_is_shown_and_cleared_without_other_files(cache: Path) -> None:
    shown = layflat("cache")
    assert shown.returncode == 0
    assert "1 file, 1.5 MB" in shown.stdout
    assert str(cache)[:40] in shown.stdout
    cleared = layflat("cache", "--clear")
    assert cleared.stdout == f"removed 1 file, 1.5 MB of {cache}\n"
    assert [path.name for path in cache.iterdir()] == ["mine.txt"]
    assert "0 files" in layflat("cache").stdout


def test_prebuilt_machine_code_is_shown_with_its_use(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stored, "PREBUILT_FOLDER", tmp_path / "prebuilt")
    assert "kernels are compiled once" in " ".join(layflat("cache").stdout.split())
    for level in (stored.host_levels()[0], "macos-aarch64-of-others"):
        (tmp_path / "prebuilt" / level).mkdir(parents=True)
    text = layflat("cache").stdout
    assert "fits this computer" in text
    assert "not for this computer" in text


def test_verbose_says_what_is_compiled_and_a_second_run_loads_no_compiler(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAYFLAT_CACHE_DIR", str(tmp_path / "cache"))
    first, second = run_twice(tmp_path, "joint", "--verbose", "sweep", "paper-small-joint")
    if any((stored.PREBUILT_FOLDER / level).is_dir() for level in stored.host_levels()):
        assert first == "\n"
    else:
        assert first.startswith("compiling sweep_joint of slow.py: ")
    assert second == "\n"


@pytest.mark.parametrize(
    "machine",
    [
        "paper-arm",
        pytest.param("paper-arm-tracking", marks=pytest.mark.slow),
        pytest.param("picking-arm", marks=pytest.mark.slow),
    ],
)
def test_a_simulation_of_known_kind_loads_no_compiler(machine: str, tmp_path: Path) -> None:
    _, second = run_twice(tmp_path, "simulate", machine, "--move", "10 deg", "--duration", "0.3 s")
    assert second == "\n"
