"""All documents of a machine are made and written, or none."""

from __future__ import annotations

from pathlib import Path

import pytest

from layflat.errors import LayflatError, OutputError
from layflat.machine import changed, load, names
from layflat.solids.documents import make_documents, write_documents

MACHINES = [name for name in names() if load(name).controller is not None]
ENDINGS = ("air.svg", "tubes.csv", "wiring.svg", "wiring.csv", "commissioning.html")


@pytest.mark.parametrize("name", MACHINES)
def test_every_machine_with_a_controller_has_all_documents_the_same_each_time(name: str) -> None:
    texts = make_documents(load(name))
    assert set(texts) == {f"{name}-{ending}" for ending in ENDINGS} | {"settings.py"}
    assert texts == make_documents(load(name))


def test_documents_are_written_whole(tmp_path: Path) -> None:
    paths = write_documents(load("paper-arm"), tmp_path / "new")
    assert {path.name: path.read_text() for path in paths} == make_documents(load("paper-arm"))
    assert set(paths) == set((tmp_path / "new").iterdir())


@pytest.mark.parametrize("machine", ["rig-kevlar", "short"])
def test_nothing_is_written_of_a_machine_that_does_not_fit(tmp_path: Path, machine: str) -> None:
    described = changed(load("paper-arm"), "controller.cycle", "2 ms") if machine == "short" else load(machine)
    with pytest.raises(LayflatError):
        write_documents(described, tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_a_folder_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="it is a file"):
        write_documents(load("paper-arm"), tmp_path / "file")
