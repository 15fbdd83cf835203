import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from layflat import extras
from layflat.errors import InputError, MissingExtraError

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]


NAME = re.compile(r"[A-Za-z0-9._-]+")
BASE = {found[0].lower() for line in PROJECT["dependencies"] if (found := NAME.match(line))}


def packages(extra: str) -> set[str]:
    """What an extra installs besides what is there anyway, other extras of ours included, as pip knows it."""
    found = set()
    for line in PROJECT["optional-dependencies"][extra]:
        if line.startswith("layflat["):
            found |= packages(line.removeprefix("layflat[").removesuffix("]"))
        else:
            found |= {name[0].lower() for name in [NAME.match(line)] if name}
    return found - BASE


@pytest.mark.parametrize("extra", extras.EXTRA_PACKAGES)
def test_the_table_is_what_pip_installs(extra: str) -> None:
    assert {name.lower() for name in extras.EXTRA_PACKAGES[extra].values()} - BASE == packages(extra)


def test_every_extra_for_use_is_in_the_table() -> None:
    assert set(PROJECT["optional-dependencies"]) - {
        "docs",
        "test",
        "lint",
        "mutants",
        "importers",
        "conformance",
        "dev",
    } == set(extras.EXTRA_PACKAGES)


def test_a_missing_package_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cobs", None)
    monkeypatch.setitem(sys.modules, "pymodbus", None)
    with pytest.raises(InputError) as caught:
        extras.require("rig", "cobs", "pymodbus", where="rig serve")
    assert str(caught.value) == (
        "rig serve: needs cobs and pymodbus, not installed; install it: pip install 'layflat[rig]'"
    )
    assert not extras.available("rig", "cobs")
    with pytest.raises(MissingExtraError, match="pymodbus"):
        extras.require("rig")


def test_a_package_that_is_there() -> None:
    extras.require("tune")
    assert extras.available("tune", "cma")
    assert extras.import_extra("tune", "cma").__name__ == "cma"
    assert extras.import_extra("logs", "pyarrow.parquet").__name__ == "pyarrow.parquet"


def test_a_package_that_can_not_be_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "ezdxf.py").write_text("import a_library_that_is_not_there", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    for name in [name for name in sys.modules if name.partition(".")[0] == "ezdxf"]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(MissingExtraError, match=r"needs ezdxf, can't be imported .No module named 'a_library_that"):
        extras.import_extra("drawing", "ezdxf", where="design")


WITHOUT = """
import subprocess
import sys
for name in {names!r}:
    sys.modules[name] = None
sys.argv = {argv!r}
from layflat.cli import main
main()
"""


@pytest.mark.parametrize(
    ("words", "extra"),
    [
        ("tune paper-small-joint", "tune"),
        ("study run valves", "study"),
        ("rig run paper-arm --driver simulated", "rig"),
        ("rig serve paper-arm --modbus 0", "rig"),
        ("rig serve paper-arm --serial", "rig"),
        ("rig check paper-arm --driver modbus://127.0.0.1:1", "rig"),
        ("log info run.mcap", "rig"),
        ("log check run.mcap", "logs"),
        ("log check run.parquet", "logs"),
        ("motion plan tour paper-arm", "motion"),
        ("cell pack --picks 1", "cell"),
        ("arm view paper-arm", "view"),
        ("foxglove run.mcap", "foxglove"),
        ("foxglove run.nc --out new.mcap", "foxglove"),
        ("arm view paper-arm --png arm.png", "view"),
    ],
)
def test_a_command_without_its_extra_says_so_at_once(words: str, extra: str, tmp_path: Path) -> None:
    (tmp_path / "run.mcap").write_bytes(b"\x89MCAP0\r\n")
    (tmp_path / "run.parquet").write_bytes(b"PAR1")
    names = sorted({name for packages in extras.EXTRA_PACKAGES.values() for name in packages} - {"pandas"})
    code = WITHOUT.format(names=names, argv=["layflat", *words.split()])
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=tmp_path, timeout=120
    )
    assert done.returncode == 2, done.stderr
    (line,) = done.stderr.splitlines()
    assert "needs " in line
    assert line.endswith(f"install it: pip install 'layflat[{extra}]'")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.mcap", "run.parquet"]


def test_what_needs_no_extra_imports_none(tmp_path: Path) -> None:
    names = sorted({name for packages in extras.EXTRA_PACKAGES.values() for name in packages} - {"pandas"})
    code = WITHOUT.format(names=names, argv=["layflat", "joint", "design", "paper-small-joint"])
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "build/design/paper-small-joint-small-cam.svg").exists()
