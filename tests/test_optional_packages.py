import sys
import tomllib
from pathlib import Path

import pytest

from layflat import extras
from layflat.errors import InputError, MissingExtraError

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def packages(extra: str) -> set[str]:
    """What an extra installs, other extras of ours included, as pip knows it."""
    found = set()
    for line in PROJECT["optional-dependencies"][extra]:
        if line.startswith("layflat["):
            found |= packages(line.removeprefix("layflat[").removesuffix("]"))
        else:
            found.add(line.partition(">")[0].partition("[")[0].lower())
    return found


@pytest.mark.parametrize("extra", extras.EXTRAS)
def test_the_table_is_what_pip_installs(extra: str) -> None:
    assert {name.lower() for name in extras.EXTRAS[extra].values()} == packages(extra)


def test_every_extra_for_use_is_in_the_table() -> None:
    assert set(PROJECT["optional-dependencies"]) - {"test", "lint", "dev"} == set(extras.EXTRAS)


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
    assert extras.module("tune", "cma").__name__ == "cma"
    assert extras.module("logs", "pyarrow.parquet").__name__ == "pyarrow.parquet"


def test_a_package_that_can_not_be_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "ezdxf.py").write_text("import a_library_that_is_not_there", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    for name in [name for name in sys.modules if name.partition(".")[0] == "ezdxf"]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(MissingExtraError, match=r"needs ezdxf, can't be imported .No module named 'a_library_that"):
        extras.module("drawing", "ezdxf", where="design")
