"""The names at the top of the package: there, light, the same for editors, and helpful where one is mistyped."""

import ast
import subprocess
import sys
from pathlib import Path
from pkgutil import resolve_name

import pytest

import layflat

STUB = Path(layflat.__file__).with_suffix(".pyi")


@pytest.mark.parametrize("name", layflat.__all__)
def test_every_public_name_is_there(name: str) -> None:
    found = getattr(layflat, name)
    assert found.__name__.rpartition(".")[2] == name
    assert found.__doc__


def test_editors_see_the_names_that_there_are() -> None:
    tree = ast.parse(STUB.read_text(encoding="utf-8"))
    homes = {alias.name: node.module for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert set(homes) == {*layflat.__all__, "__version__"}
    for name, home in homes.items():
        assert resolve_name(f"{home}:{name}") is getattr(layflat, name)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("rollot", "did you mean rollout?"),
        ("Mashine", "did you mean Machine"),
        ("openrun", "did you mean open_run"),
        ("xyz", "it offers Batch, DesignError, "),
    ],
)
def test_another_name_says_which_is_near(name: str, told: str) -> None:
    with pytest.raises(AttributeError, match=f"module 'layflat' has no attribute '{name}'; {told}"):
        getattr(layflat, name)


def loaded(code: str, *heavy: str) -> str:
    """Which of some packages are loaded after a piece of code, in a fresh interpreter."""
    shown = f"{code}; import sys; print(sorted(set({heavy!r}) & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", shown], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_importing_costs_nothing() -> None:
    assert loaded("import layflat", "numpy", "numba", "pydantic", "xarray", "inspect") == "[]"


def test_importing_takes_less_than_a_twentieth_of_a_second() -> None:
    """By the time of the processor, which other processes do not change."""
    code = "import time; start = time.process_time(); import layflat; print(time.process_time() - start)"
    times = [
        float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)
        for _ in range(3)
    ]
    assert min(times) < 0.05


def test_a_machine_and_a_scenario_need_neither_compiler_nor_scipy_nor_matplotlib() -> None:
    code = (
        "import layflat as lf; lf.names(); m = lf.load('paper-arm'); lf.changed(m, 'arm.payload', '2 kg'); "
        "lf.Scenario(demand='5 deg'); m._repr_html_(); lf.plot"
    )
    assert loaded(code, "numba", "llvmlite", "scipy", "matplotlib", "xarray", "pandas") == "[]"
