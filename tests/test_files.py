import errno
import resource
import signal
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import xarray

from layflat.errors import OutputError
from layflat.files import check_file, check_folder, whole_file, whole_folder
from layflat.outputs import OutputCommand, run_command
from layflat.sim.dataset import save_run


def test_a_file_appears_whole(tmp_path: Path) -> None:
    target = tmp_path / "deep" / "file.txt"
    with whole_file(target) as temporary:
        temporary.write_text("half", encoding="utf-8")
        assert not target.exists()
    assert target.read_text(encoding="utf-8") == "half"
    assert [path.name for path in target.parent.iterdir()] == ["file.txt"]


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    target = tmp_path / "file.txt"
    target.write_text("old", encoding="utf-8")

    def fail() -> None:
        with whole_file(target) as temporary:
            temporary.write_text("new", encoding="utf-8")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert target.read_text(encoding="utf-8") == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["file.txt"]


def test_folder_check_leaves_nothing(tmp_path: Path) -> None:
    assert check_folder(tmp_path / "deep" / "out") == tmp_path / "deep" / "out"
    assert check_folder(tmp_path) == tmp_path
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_can_not_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(OutputError, match="can't write here"):
        check_folder(tmp_path / "file" / "out")


@pytest.fixture
def nearly_full(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """No file may grow beyond 4 KiB, as on a disk with no more space."""
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # a compiled module that is cut off stays
    before, handler = resource.getrlimit(resource.RLIMIT_FSIZE), signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, handler)


@pytest.mark.usefixtures("nearly_full")
def test_a_full_disk_is_told_and_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "file.txt"
    target.write_text("old", encoding="utf-8")
    with (
        pytest.raises(OutputError, match=r"can't write here \(File too large\); free some space"),
        whole_file(target) as temporary,
    ):
        temporary.write_bytes(bytes(10000))
    assert target.read_text(encoding="utf-8") == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["file.txt"]
    with pytest.raises(OutputError, match="free some space"):
        check_folder(tmp_path / "out" / "deep")
    assert [path.name for path in tmp_path.iterdir()] == ["file.txt"]


@pytest.mark.usefixtures("nearly_full")
def test_a_full_disk_is_told_where_a_library_does_not_say_so(tmp_path: Path) -> None:
    def spoilt(path: Path) -> None:
        with suppress(OSError):
            path.write_bytes(bytes(10000))
        raise RuntimeError("a library's own")

    with pytest.raises(OutputError, match="can't write here"), whole_file(tmp_path / "file") as temporary:
        spoilt(temporary)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("nearly_full")
def test_a_data_set_on_a_full_disk(tmp_path: Path) -> None:
    """HDF5 ends the process with a segmentation fault where it writes to the disk itself."""
    with pytest.raises(OutputError, match="free some space"):
        save_run(xarray.Dataset({"x": ("time", np.random.default_rng(1).random(5000))}), tmp_path / "run.nc")
    assert list(tmp_path.iterdir()) == []


def test_another_error_stays_what_it_is(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), whole_file(tmp_path / "a"):
        (tmp_path / "not there").read_bytes()
    with pytest.raises(ValueError, match="something else"), whole_file(tmp_path / "a"):
        raise ValueError("something else")


def test_a_folder_in_place_of_a_file_is_refused_before_any_work(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"is a folder; give the name of a file"):
        check_file(tmp_path)
    assert check_file(tmp_path / "new" / "result.json") == tmp_path / "new" / "result.json"
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_place_of_a_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x", encoding="utf-8")
    for folder in (tmp_path / "file", tmp_path / "file" / "inner" / "more"):
        with pytest.raises(OutputError) as caught:
            check_folder(folder)
        assert str(caught.value) == f"{tmp_path / 'file'}: can't write here (it is a file); give the name of a folder"


def fill(folder: Path, text: str, fault: BaseException | None = None) -> None:
    with whole_folder(folder, {"part"}) as temporary:
        (temporary / "part").mkdir()
        (temporary / "part" / "text").write_text(text, encoding="utf-8")
        if fault is not None:
            raise fault


def test_a_folder_appears_whole(tmp_path: Path) -> None:
    for folder in (tmp_path / "new" / "one", tmp_path / "empty"):
        if folder.name == "empty":
            folder.mkdir()
        fill(folder, "x")
        assert (folder / "part" / "text").read_text(encoding="utf-8") == "x"
        assert [path.name for path in folder.parent.iterdir() if path.name.startswith(".")] == []


@pytest.mark.parametrize("fault", [KeyboardInterrupt(), ValueError("broken"), OutputError("full")])
def test_a_failure_leaves_no_part_of_a_folder(tmp_path: Path, fault: BaseException) -> None:
    with pytest.raises(type(fault)):
        fill(tmp_path / "one", "x", fault)
    assert list(tmp_path.iterdir()) == []


def test_the_error_of_a_file_in_a_folder_names_the_folder(tmp_path: Path) -> None:
    folder = tmp_path / "one"

    def fail() -> None:
        with whole_folder(folder, {"part"}) as temporary, whole_file(temporary / "part" / "file.txt"):
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OutputError) as refused:
        fail()
    right = "free some space, or give another folder"
    assert str(refused.value) == f"{folder}: can't write here (No space left on device); {right}"


def test_only_force_replaces_a_folder_and_only_one_of_its_kind(tmp_path: Path) -> None:
    fill(tmp_path / "one", "old")
    said = "one: is not empty, it holds 'part'; give a new folder, or --force"
    with run_command(OutputCommand("make", ("make",))), pytest.raises(OutputError, match=said):
        fill(tmp_path / "one", "new")
    with pytest.raises(OutputError, match=r"one: is not empty, it holds 'part'; give a new folder$"):
        fill(tmp_path / "one", "new")  # from Python, where nothing is forced
    with run_command(OutputCommand("make", ("make", "--force"))):
        with pytest.raises(ValueError, match="broken"):
            fill(tmp_path / "one", "new", ValueError("broken"))
        assert (tmp_path / "one" / "part" / "text").read_text(encoding="utf-8") == "old"
        fill(tmp_path / "one", "new")
        assert (tmp_path / "one" / "part" / "text").read_text(encoding="utf-8") == "new"
        (tmp_path / "one" / "mine").write_text("mine", encoding="utf-8")
        with pytest.raises(OutputError, match=r"one: is not empty, it holds 'mine'; give a new folder$"):
            fill(tmp_path / "one", "new")
    assert [path.name for path in tmp_path.iterdir()] == ["one"]


def test_the_working_folder_can_be_filled_and_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with run_command(OutputCommand("make", ("make", "--force"))):
        for text in ("old", "new"):
            fill(Path(), text)
            assert [path.name for path in tmp_path.iterdir()] == ["part"]
            assert (tmp_path / "part" / "text").read_text(encoding="utf-8") == text


@pytest.mark.parametrize("fault", [KeyboardInterrupt(), OSError("broken")])
def test_a_folder_keeps_its_content_where_the_new_one_does_not_arrive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: BaseException
) -> None:
    fill(tmp_path / "one", "old")
    replace, calls = Path.replace, []

    def fail_once(self: Path, target: Path) -> Path:
        calls.append(target)
        if len(calls) == 2:  # the old part has left
            raise fault
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", fail_once)
    with run_command(OutputCommand("make", ("make", "--force"))), pytest.raises(type(fault)):
        fill(tmp_path / "one", "new")
    assert (tmp_path / "one" / "part" / "text").read_text(encoding="utf-8") == "old"
    assert [path.name for path in (tmp_path / "one").iterdir()] == ["part"]


@pytest.mark.usefixtures("nearly_full")
def test_a_full_disk_is_told_for_a_folder_too(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="free some space"):
        fill(tmp_path / "one", "x" * 10000)
    assert list(tmp_path.iterdir()) == []
