"""FMUs of several systems are small; laws without a counterpart in C are compiled, plain Python is refused."""

import os
import re
import zipfile
from pathlib import Path

import pytest

from layflat.errors import KindError
from layflat.export.fmu import libraries, writer
from layflat.machine import load
from tests.export.fmu.runs import check_fmus
from tests.test_outside_kinds import outside_machine, own_sources

pytestmark = pytest.mark.compiled

LIMITS = {"fmi2": 200_000, "fmi3": 250_000}
"""Max sizes of FMUs for Linux, Windows and macOS by version, bytes: on four kinds of computers, and on five."""


def test_laws_without_a_counterpart_in_c_are_compiled_by_numba(
    compiler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not os.environ.get("LAYFLAT_EXPORT_CHECK"):
        pytest.skip("compiles for a minute: set LAYFLAT_EXPORT_CHECK=1")

    def refuse(_: object) -> str:
        raise KindError("a construct")

    monkeypatch.setattr(libraries, "find_spec", lambda _: None)
    monkeypatch.setattr(writer, "law_source", refuse)
    check_fmus(load("paper-arm"), tmp_path)


@pytest.mark.parametrize("name", ["paper-arm", "paper-arm-tracking", "picking-arm"])
def test_fmus_of_three_systems_are_small(name: str, tmp_path: Path) -> None:
    if name != "paper-arm" and not os.environ.get("LAYFLAT_EXPORT_CHECK"):
        pytest.skip("compiles for a minute: set LAYFLAT_EXPORT_CHECK=1")
    pytest.importorskip("ziglang", reason="needs ziglang: pip install 'layflat[export]'")
    files = list(writer.write_fmus(load(name), tmp_path / "fmus", target="fmu", precision="double"))
    for path in files[:-1]:
        end = path.stem[-4:]
        version = {name: one for one, name in writer.FMI_VERSIONS.items()}[end]
        with zipfile.ZipFile(path) as archive:
            names = [one for one in archive.namelist() if one.startswith("binaries/")]
            exported = {*re.findall(rb"fmi[23]DoStep", b"".join(map(archive.read, names)))}
        folders = {system.folder_of(version) for system in libraries.LINKED_SYSTEMS} - {""}
        assert {one.split("/")[1] for one in names} == folders
        assert exported == {f"{end}DoStep".encode()}
        assert path.stat().st_size < LIMITS[end]


def test_a_law_in_plain_python_is_refused(tmp_path: Path, compiler: str) -> None:
    with own_sources():
        machine = load(outside_machine(tmp_path, ["plain_relay"]))
        with pytest.raises(KindError, match="is plain Python; it can't run in C; decorate its functions"):
            list(writer.write_fmus(machine, tmp_path / "fmus", target="fmu", precision="double"))
