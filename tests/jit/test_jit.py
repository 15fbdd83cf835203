import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import njit
from numba.core.runtime import _nrt_python as counted  # type: ignore[attr-defined]

import layflat
from layflat.jit import Kernel, by_kind, cache_folder, kernel, law, libraries
from layflat.jit.cache import included_sources, kernel_sources, remove_stale, source_digest
from layflat.jit.compiler import SUPPORTED_VERSIONS, compile_cached
from layflat.jit.ordering import order_instructions
from layflat.physics.arms.planar import OneLink
from layflat.physics.hose import PolynomialStroke
from layflat.registers import interpreted

PACKAGE = Path(layflat.__file__).parent

KERNEL = """
from layflat.jit import kernel
from layflat.physics.hose import PolynomialStroke, torque_per_pressure

@kernel
def doubled(stroke, s):
    return 2.0 * torque_per_pressure(stroke, s)

print(doubled(PolynomialStroke(1.0, 2.0, 0.0, 0.0, 0.0), 3.0), sum(doubled.dispatcher.stats.cache_hits.values()))
"""

SHORT_RUN = """
import sys
sys.path.insert(0, sys.argv[1])
import numpy as np
from layflat.control.paper.law import Settings
from tests.physics.plants import GAINS, AROUND, SIGNALS, JOINTS, TWO_LINKS, CYCLE, signals
from layflat.lanes import Like, leaves
from layflat.sim.kernel import COLUMNS, run_cycles
from layflat.sim.loop import Case, Timing

noise = np.random.default_rng(0).normal(size=(7, 2, 2))
acting = signals(6, 2, demand=[0.3, -0.2], brake=[6.7, 2.2], load=[1.0, 0.5], payload=1.5, opening=np.nan)
start, filled = np.zeros(2), np.full((2, 2), 3e5)
case = Case(TWO_LINKS, JOINTS, Settings((GAINS,) * 2), AROUND)
timing = Timing(CYCLE, 20, 4)
records, report = np.empty((25, 2, COLUMNS)), np.empty((25, 2, SIGNALS))
rest = acting, noise, timing, np.zeros(3, np.int64), records, report
run_cycles(Like.from_tuple(case), np.fromiter(leaves(case), float), start, filled, *rest)
sys.stdout.buffer.write(records.tobytes())
"""


def python(code: Path, *args: str, **environment: str) -> bytes:
    done = subprocess.run(
        [sys.executable, str(code), *args], env={**os.environ, **environment}, capture_output=True, check=True
    )
    return done.stdout


def test_a_changed_law_is_not_served_from_the_cache(tmp_path: Path) -> None:
    shutil.copytree(PACKAGE, tmp_path / "src" / "layflat", ignore=shutil.ignore_patterns("__pycache__"))
    script = tmp_path / "kernel.py"
    script.write_text(KERNEL)

    def result() -> list[str]:
        paths = {"PYTHONPATH": str(tmp_path / "src"), "LAYFLAT_CACHE_DIR": str(tmp_path / "cache")}
        return python(script, NUMBA_DISABLE_JIT="0", **paths).decode().split()

    assert result() == ["14.0", "0"]
    assert result() == ["14.0", "1"]
    laws = tmp_path / "src" / "layflat" / "physics" / "hose.py"
    changed = laws.read_text().replace("return stroke.k0 + s *", "return 10.0 * stroke.k0 + s *")
    assert changed != laws.read_text()
    laws.write_text(changed)
    assert result() == ["32.0", "0"]


@pytest.mark.compiled
def test_a_run_without_the_jit_has_the_same_bits(tmp_path: Path) -> None:
    script = tmp_path / "short_run.py"
    script.write_text(SHORT_RUN)
    root = str(Path(__file__).parents[2])
    compiled, interpreted = (python(script, root, NUMBA_DISABLE_JIT=off) for off in ("0", "1"))
    assert len(compiled) == 25 * 2 * 18 * 8
    assert compiled == interpreted


def test_kernels_are_cached_in_a_folder_of_these_sources() -> None:
    loop = PACKAGE / "sim" / "kernel.py"
    folder = cache_folder(loop)
    assert folder is not None
    assert folder.name == source_digest(loop, included_sources())


def test_machine_code_depends_on_laws_alone() -> None:
    texts = {path: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    kernels = [path for path, text in texts.items() if re.search(r"\n *@(portable_)?kernel\b", text)]
    assert PACKAGE / "sim" / "kernel.py" in kernels
    strangers = {
        f"{path.name} depends on {f.relative_to(PACKAGE)}"
        for path in kernels
        for f in kernel_sources(path)
        if f.relative_to(PACKAGE).parts[0] not in ("jit", "lanes.py", "registers.py", "physics", "control")
        and f.name != "__init__.py"
        and not any(word in texts[f] for word in ("NamedTuple", "IntEnum", "@law", "kernel", "layflat.lanes"))
    }
    assert not strangers


OUTSIDE = """
import sys
from pathlib import Path
from layflat.jit import cache_folder, include_source

print(cache_folder(Path(__file__)))
include_source(Path(sys.argv[1]))
print(cache_folder(Path(__file__)))
"""


def test_laws_from_outside_have_machine_code_of_their_own(tmp_path: Path) -> None:
    script, laws = tmp_path / "kernel.py", tmp_path / "laws.py"
    script.write_text(OUTSIDE)
    laws.write_text("number = 1\n")
    first = python(script, str(laws)).split()
    laws.write_text("number = 2\n")
    second = python(script, str(laws)).split()
    assert first[0] == second[0]
    assert len({first[0], first[1], second[1]}) == 3


WITHOUT_COMPILER = """
import sys
from layflat.machine import load, parameters
import layflat.sim.kernel

parameters.joints(load("paper-arm"))
print(*(name for name in ("numba", "llvmlite") if name in sys.modules))
"""


def test_describing_a_machine_loads_no_compiler(tmp_path: Path) -> None:
    script = tmp_path / "describe.py"
    script.write_text(WITHOUT_COMPILER)
    assert python(script).strip() == b""


def test_no_cache_where_none_can_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("LAYFLAT_CACHE_DIR", str(tmp_path / "file"))
    assert cache_folder(PACKAGE / "sim" / "kernel.py") is None


@law
def length(arm: Any, scale: float) -> float:
    return float(scale * arm.length)


@law
def slope(stroke: Any, scale: float) -> float:
    return float(scale * stroke.k1)


chosen = by_kind({OneLink: length, PolynomialStroke: slope})


@kernel
def both(arm: Any, stroke: Any) -> Any:
    return chosen(arm, 2.0), chosen(stroke, 3.0)


def test_the_kind_of_the_first_argument_picks_the_law() -> None:
    arm, stroke = OneLink(1.0, 2.0, 0.4, 0.0, 0.0), PolynomialStroke(1.0, 5.0, 0.0, 0.0, 0.0)
    assert both(arm, stroke) == (0.8, 15.0)
    assert chosen(arm, 2.0) == 0.8


def test_laws_keep_their_names_and_docs() -> None:
    from layflat.physics.hose import roller_torque

    assert roller_torque.__name__ == "roller_torque"
    assert "Eq. (1)" in str(roller_torque.__doc__)


def test_only_machine_code_is_removed_and_only_after_a_month(tmp_path: Path) -> None:
    old, young, other = tmp_path / ("a" * 16), tmp_path / ("b" * 16), tmp_path / "photographs-old"
    for folder in (old, young, other):
        folder.mkdir()
        (folder / "kernel.nbc").write_bytes(b"")
    for folder in (old, other):
        os.utime(folder, (0, 0))
    remove_stale(tmp_path)
    assert sorted(tmp_path.iterdir()) == [young, other]


def test_the_versions_that_fit_are_those_that_are_installed() -> None:
    project = tomllib.loads((PACKAGE.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for package, (first, end) in SUPPORTED_VERSIONS.items():
        assert f"{package}>={'.'.join(map(str, first))},<{'.'.join(map(str, end))}" in project["dependencies"]


@pytest.mark.compiled
def test_of_a_law_there_is_no_machine_code() -> None:
    """It is inlined: to make any would take a sixth of the time of a kernel."""

    @law
    def doubled(x):  # type: ignore[no-untyped-def]
        return 2.0 * x

    @kernel
    def quadrupled(x):  # type: ignore[no-untyped-def]
        return doubled(doubled(x))

    assert quadrupled(1.5) == 6.0
    for one, compiled in ((doubled, False), (quadrupled, True)):
        (made,) = one.dispatcher.overloads.values()  # type: ignore[attr-defined]
        assert (made.library.get_pointer_to_function(made.fndesc.llvm_func_name) != 0) == compiled


class Pair(NamedTuple):
    first: float
    second: int
    third: bool = True


@pytest.mark.skipif(interpreted(), reason="nothing is compiled")
def test_laws_and_what_is_compiled_elsewhere_call_each_other_with_named_tuples() -> None:
    """A law is handed them whole, all else number by number: what is handed the wrong ones can't be inlined."""

    @njit
    def elsewhere(one: Pair, other: Pair) -> Any:
        return one.first - other.second

    @law
    def within(one: Pair, other: Pair) -> Any:
        return Pair(elsewhere(one, other) + sum(one) + len(one), other.second, one.first > other.first)

    @law
    def around(one: Pair) -> Any:
        return within(within(one, Pair(4.0, 8)), one)

    @kernel
    def run(one: Pair) -> Any:
        return around(one)

    @njit
    def run_elsewhere(one: Pair) -> Any:
        return around(one)

    given = Pair(1.5, 2)
    assert run(given) == run_elsewhere(given) == around(given)
    for one in (run.dispatcher, run_elsewhere):  # type: ignore[attr-defined]
        (machine_code,) = one.inspect_llvm().values()
        assert not re.search(r"call i32 @\S*locals_3e\d+(?:elsewhere|within|around)", machine_code)


@pytest.mark.skipif(interpreted(), reason="nothing is compiled")
def test_what_laws_allocate_and_hand_on_is_given_back() -> None:
    @law
    def made(count: int) -> Any:
        return np.full(count, 2.0), count

    @law
    def summed(count: int) -> Any:
        return made(count)[0].sum()

    @law
    def handed_on(one: Any) -> Any:
        return one

    @kernel
    def used(kept: Any, times: int) -> float:
        total = 0.0
        for _ in range(times):
            total += summed(5) + handed_on(made(5))[0].sum() + handed_on((kept, 1))[0].sum()
        return total

    kept = np.ones(10)
    assert used(kept, 1) == 30.0
    counted.memsys_enable_stats()
    before = counted.memsys_get_stats_alloc(), counted.memsys_get_stats_free()
    assert used(kept, 1000) == 30_000.0
    allocated, freed = counted.memsys_get_stats_alloc() - before[0], counted.memsys_get_stats_free() - before[1]
    assert allocated == freed >= 2000
    assert sys.getrefcount(kept) == 2


@pytest.mark.skipif(interpreted(), reason="nothing is compiled")
@pytest.mark.parametrize("text", ["", "nonsense"])
def test_a_kernel_is_put_in_order_where_llvm_reads_it_again(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []

    def in_order(module: str) -> str:
        seen.append(module)
        return text or order_instructions(module)

    monkeypatch.setattr(libraries, "order_instructions", in_order)
    thrice = compile_cached(lambda x: 3.0 * x, None)
    assert thrice(2.0) == 6.0
    assert len(seen) == 1
    assert "fmul double" in seen[0]


def test_ctrl_c_in_machine_code_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: float) -> None:
        error = SystemError("returned a result with an exception set")
        raise error from KeyboardInterrupt()

    kernel = Kernel(lambda x: x)
    monkeypatch.setattr(Kernel, "dispatcher", interrupted)
    with pytest.raises(KeyboardInterrupt):
        kernel(1.0)
