"""What commands may replace: nothing that they did not write from these inputs, unless --force says so."""

import os
from pathlib import Path

import pytest

from layflat.errors import OutputError
from layflat.files import check_file, check_folder, whole_file, write_text
from layflat.outputs import OutputCommand, parse_command, run_command
from layflat.study.folder import StudyFolder
from tests.cli.commands import layflat, refused

WRITING = {
    "joint size": ("joint", "size", "--torque", "12 N m", "--stroke", "110 deg", "--supply", "5 bar", "-o", "out"),
    "excite": ("excite", "paper-small-joint", "-o", "out/demand.csv"),
    "machine schema": ("machine", "schema", "-o", "out/schema.json"),
    "arm export": ("arm", "export", "picking-arm", "-o", "out/arm.urdf"),
}


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("words", WRITING.values(), ids=WRITING)
def test_a_command_may_repeat_itself_and_nothing_else_is_lost(words: tuple[str, ...], tmp_path: Path) -> None:
    assert layflat(*words, cwd=tmp_path).returncode == 0
    written = contents(tmp_path / "out")
    assert layflat(*words, cwd=tmp_path).returncode == 0, "the same command"
    name = sorted(written)[-1]
    edited = tmp_path / "out" / name
    edited.write_bytes(written[name] + b"\n")
    line = refused(*words, cwd=tmp_path)
    assert name in line
    assert "--force" in line
    assert edited.read_bytes() == written[name] + b"\n"
    assert layflat(*words, "--force", cwd=tmp_path).returncode == 0
    assert edited.read_bytes()[-2:] == written[name][-2:]


def command(*typed: str, told: list[str] | None = None) -> OutputCommand:
    return parse_command(typed, ["arm", "cell", "joint", "rig", "study"], (told if told is not None else []).append)


def test_other_words_of_a_quick_command_say_what_they_replace(tmp_path: Path) -> None:
    told: list[str] = []
    for size in ("1", "2"):
        with run_command(command("joint", "size", "--size", size, told=told)):
            check_folder(tmp_path, "a.toml", "b.toml")
            for name in ("a.toml", "b.toml"):
                write_text(tmp_path / name, size)
    assert told == [f"{tmp_path / 'a.toml'}: replaced what `layflat joint size --size 1` wrote"]
    assert (tmp_path / "b.toml").read_text(encoding="utf-8") == "2"


@pytest.mark.parametrize("words", [("cell", "pack", "--study"), ("joint", "size"), ("rig", "faults")])
def test_what_took_long_or_is_anothers_stays(words: tuple[str, ...], tmp_path: Path) -> None:
    with run_command(command("cell", "pack", "--picks", "2")):
        write_text(tmp_path / "results.json", "1")
    with (
        run_command(command(*words)),
        pytest.raises(OutputError, match=r"holds what `layflat cell pack --picks 2` .* --force"),
    ):
        check_folder(tmp_path, "results.json", costly=True)
    with run_command(command(*words, "--force")):
        check_folder(tmp_path, "results.json", costly=True)


def test_where_results_go_is_no_input(tmp_path: Path) -> None:
    for place in (("-o", "x"), ("--out", "y"), ("--out=z",), ()):
        with run_command(command("cell", "pack", "--picks", "2", *place)):
            check_folder(tmp_path, "results.json", costly=True)
            write_text(tmp_path / "results.json", "1")


def test_what_is_there_already_may_be_written_again_and_stays_whose_it_is(tmp_path: Path) -> None:
    with run_command(command("arm", "import", "a.urdf")):
        write_text(tmp_path / "link.stl", "solid")
    with run_command(command("arm", "export", "a.toml")):
        write_text(tmp_path / "link.stl", "solid")
        with pytest.raises(OutputError, match=r"holds what `layflat arm import a\.urdf` wrote"):
            write_text(tmp_path / "link.stl", "other")
    assert (tmp_path / "link.stl").read_text(encoding="utf-8") == "solid"
    assert [path.name for path in tmp_path.iterdir()] == ["link.stl"]


@pytest.mark.parametrize("change", ["edited", "protected", "somebody's", "moved here"])
def test_what_a_person_did_is_kept(change: str, tmp_path: Path) -> None:
    path = tmp_path / "wrist.toml"
    with run_command(command("joint", "size")):
        if change in ("edited", "protected"):
            write_text(path, "first")
    if change == "protected":
        path.chmod(0o444)
    elif change == "moved here":
        with run_command(command("joint", "size")):
            write_text(tmp_path / "other.toml", "hand made").rename(path)
    else:
        path.write_text("hand made", encoding="utf-8")
    before = path.read_text(encoding="utf-8")
    with (
        run_command(command("joint", "size")),
        pytest.raises(OutputError, match="--force"),
        whole_file(path) as temporary,
    ):
        temporary.write_text("second", encoding="utf-8")
    assert path.read_text(encoding="utf-8") == before
    with run_command(command("joint", "size", "--force")):
        write_text(path, "second")
    with run_command(command("joint", "size")):
        write_text(path, "third")


def test_a_machine_is_not_replaced_by_a_table(tmp_path: Path) -> None:
    (tmp_path / "h.toml").write_text('extends = "paper-small-joint"\nname = "h"\n', encoding="utf-8")
    for words in (["excite", "h.toml", "-o", "h.toml"], ["excite", "h.toml", "--out=./h.toml"]):
        for force in ([], ["--force"]):
            assert "is what this command reads" in refused(*words, *force, cwd=tmp_path)
    assert "extends" in (tmp_path / "h.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["folder", "fifo"])
def test_what_is_no_file_is_not_replaced(name: str, tmp_path: Path) -> None:
    place = tmp_path / name
    place.mkdir() if name == "folder" else os.mkfifo(place)
    for force in ([], ["--force"]):
        assert "give the name of a file" in refused("machine", "schema", "-o", str(place), *force)
    assert place.exists()


def test_python_writes_where_it_is_told(tmp_path: Path) -> None:
    write_text(tmp_path / "a", "1")
    write_text(tmp_path / "a", "2")


def test_without_a_place_for_records_all_is_somebodys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv("LAYFLAT_STATE_DIR", str(tmp_path / "file" / "state"))
    with run_command(command("joint", "size")):
        write_text(tmp_path / "a", "1")
        with pytest.raises(OutputError, match="not from this command"):
            write_text(tmp_path / "a", "2")


def test_force_replaces_another_study_and_nothing_foreign(tmp_path: Path) -> None:
    place = tmp_path / "study"
    with run_command(command("study", "run")), StudyFolder(place, 1).lock({"rows": 1}):
        (place / "chunks").mkdir()
        (place / "chunks" / "00000.parquet").write_bytes(b"done")
    with (
        run_command(command("study", "run")),
        pytest.raises(OutputError, match="or the study as it was"),
        StudyFolder(place, 1).lock({"rows": 2}),
    ):
        pass
    with run_command(command("study", "run", "--force")):
        (place / "mine.txt").write_text("mine", encoding="utf-8")
        with pytest.raises(OutputError, match=r"mine\.txt"), StudyFolder(place, 1).lock({"rows": 2}):
            pass
        (place / "mine.txt").unlink()
        with StudyFolder(place, 1).lock({"rows": 2}):
            assert not (place / "chunks").exists()
    with run_command(command("study", "run", "--force")), StudyFolder(place, 1).lock({"rows": 2}):
        assert (place / "study.json").exists()


def test_a_path_through_a_folder_that_is_not_there_replaces_nothing(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text("mine", encoding="utf-8")
    there = tmp_path / "missing" / ".." / "own.toml"
    for write in (
        lambda: write_text(there, "other"),
        lambda: write_text(there, "other", owned=True),
        lambda: check_file(there),
        lambda: check_folder(there.parent),
        lambda: check_folder(there.parent / "deep" / "deeper"),
    ):
        with pytest.raises(OutputError, match=r"leads through a folder that is not there; give the path without \.\."):
            write()
    assert [path.name for path in tmp_path.iterdir()] == ["own.toml"]
    assert (tmp_path / "own.toml").read_text(encoding="utf-8") == "mine"
    (tmp_path / "missing").mkdir()
    write_text(tmp_path / "missing" / ".." / "new.toml", "new")
    assert (tmp_path / "new.toml").is_file()
