"""Files that people wrote: read, layered and refused, without hanging and in one line."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from layflat.description import Part
from layflat.description.library import MAX_CHAIN, Library
from layflat.description.names import file_name
from layflat.description.tables import MAX_DEPTH, parse_toml
from layflat.description.text import MAX_BYTES, read_text
from layflat.errors import CellError, InputError


class WrongError(InputError):
    """Of the library that is tried here."""


@pytest.fixture
def library(tmp_path: Path) -> Library:
    folder = tmp_path / "builtin"
    folder.mkdir()
    (folder / "first.toml").write_text('a = 1\n[b]\nc = { value = 2, source = "paper", note = "p" }\nd = 3\n')
    (folder / "second.toml").write_text('extends = "first"\n[b]\nc = 5\n')
    return Library(folder, "thing", "`things` lists them", 'a = "1 m"', WrongError)


def refused(library: Library, path: Path | str) -> str:
    with pytest.raises(WrongError) as caught:
        library.tables(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_names_and_layers(library: Library) -> None:
    assert library.names == ("first", "second")
    plain, sources = library.tables("second")
    assert plain == {"a": 1, "b": {"c": 5, "d": 3}}
    assert sources["b.c"].source == "given"
    assert library.tables("first")[1]["b.c"].source == "paper"
    assert [layer.where for layer in library.layers("second")] == ["first", "second"]


def test_files_extend_files_from_their_own_folder(library: Library, tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "base.toml").write_text('extends = "first"\nomits = ["b.d"]\n')
    mine = tmp_path / "mine.toml"
    mine.write_text('extends = "deep/base.toml"\n[e]\nf = true\n')
    assert library.tables(mine)[0] == {"a": 1, "b": {"c": 2}, "e": {"f": True}}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('extends = "nowhere.toml"', "mine.toml: extends: {}/nowhere.toml: can't be read (No such file or directory)"),
        ('extends = "fist"', "mine.toml: extends: {}/fist: no such thing; did you mean 'first'?"),
        ('extends = ""', "extends: '' is not a name"),
        ("extends = 3", "extends: 3 is not a name"),
        ('extends = "mine.toml"', "extends itself through"),
        ('extends = "./../x/../{}/mine.toml"', "extends"),
        ('extends = "first"\nomits = "a"', "omits: 'a' is not a list of names"),
        ('extends = "first"\nomits = ["b.x"]', "omits: 'x' is not there to omit"),
        ('extends = "first"\nomits = ["a.b"]', "omits: 'a.b' is not there to omit"),
        ("a = 1\na = 2\n", "has a twice (line"),
        ("[b]\nc = 1\nd = 2\nc = 3\n\n\n[e]\n", "has c twice (line"),
        ("[b]\n[c]\n[b]\n", "has [b] twice (line 3); keep one"),
        ("a = 1\n[a]\n", "has [a] twice"),
        ("a = [1, 2", "is not TOML"),
        ("a = 1 kg", "is not TOML: expected newline or end of document after a statement at line 1: 'a = 1 kg'"),
        ("a = 1e300", "a: 1e+300 is out of range"),
        (".".join("a" * 5000) + " = 1", "is nested too deeply; use at most"),
        ("a = " + "[" * 3000 + "]" * 3000, "is nested too deeply"),
        ("a = " + "{b = " * 3000 + "1" + "}" * 3000, "is nested too deeply"),
        ("[" + ".".join("a" * 30) + "]\nb = 1", "is nested too deeply"),
    ],
)
def test_a_broken_file_is_one_line(library: Library, tmp_path: Path, text: str, said: str) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(text.replace("{}", tmp_path.name))
    assert said.replace("{}", str(tmp_path)) in refused(library, mine)


def test_a_byte_order_mark_and_windows_lines_are_read(library: Library, tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_bytes(b"\xef\xbb\xbfa = 1\r\n[b]\r\nc = 2\r\n")
    assert library.tables(mine)[0] == {"a": 1, "b": {"c": 2}}


def test_what_is_no_file_is_refused_at_once(library: Library, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "large.toml").write_bytes(b"#" * (MAX_BYTES + 1))
    (tmp_path / "utf16.toml").write_text("a = 1", encoding="utf-16")
    (tmp_path / "loop.toml").symlink_to(tmp_path / "loop.toml")
    assert "is a pipe or a device, not a file" in refused(library, tmp_path / "pipe.toml")
    assert "is a pipe or a device, not a file" in refused(library, "/dev/zero")
    assert "is a folder" in refused(library, tmp_path / "folder.toml")
    assert "is larger than 4 MB" in refused(library, tmp_path / "large.toml")
    assert "is not a text file in UTF-8" in refused(library, tmp_path / "utf16.toml")
    assert "can't be read" in refused(library, tmp_path / "loop.toml")
    assert "can't be read" in refused(library, "x" * 5000 + ".toml")
    assert "is not the name of a file" in refused(library, "a\0b.toml")
    assert "no such thing; `things` lists them" in refused(library, "pears")


def test_text_of_other_files_is_read_alike(tmp_path: Path) -> None:
    with pytest.raises(CellError, match="is a folder; give a file"):
        read_text(tmp_path, "here", "give a file", CellError)


def test_as_deep_as_allowed() -> None:
    text = ".".join("a" * MAX_DEPTH) + " = 1"
    assert parse_toml(text, "x", "")["a"]["a"]


@pytest.mark.parametrize("name", ["mine", "paper-arm", "My arm (2)", "arm_2.1", "Gelenk-für-Äpfel", "a=1,b@2"])
def test_names_that_may_be_files(name: str) -> None:
    assert file_name(name, "--name") == name


NO_FILES = [
    "",
    "../evil",
    "/abs/path",
    "a/b",
    "a\\b",
    "a\0b",
    "a\nb",
    ".hidden",
    "-rf",
    " a",
    "a ",
    "a.",
    "con",
    "LPT1.txt",
]
NO_NAMES = ["x" * 101, "a:b", "a*b", "a?b", 'a"b', "a|b", "<a>", "~", "..", "\u202eevil"]


@pytest.mark.parametrize("name", NO_FILES + NO_NAMES)
def test_names_that_may_not(name: str) -> None:
    with pytest.raises(InputError, match=r"^--name: .*; begin with a letter or a digit"):
        file_name(name, "--name")


def test_parts_are_frozen() -> None:
    class Mine(Part):
        a: int = 1

    with pytest.raises(ValueError, match="frozen"):
        Mine().a = 2  # type: ignore[misc]


@pytest.mark.parametrize("circle", [False, True])
@pytest.mark.parametrize("count", [1, 2, MAX_CHAIN + 1, MAX_CHAIN + 2, 2 * MAX_CHAIN])
def test_a_long_chain_is_not_called_a_circle(library: Library, tmp_path: Path, count: int, circle: bool) -> None:
    """Chains of `count` files, the last of which extends the first or nothing."""
    for i in range(count):
        base = f"{i + 1}.toml" if i + 1 < count else "0.toml"
        text = f'extends = "{base}"' if circle or i + 1 < count else "a = 1"
        (tmp_path / f"{i}.toml").write_text(text, encoding="utf-8")
    first = tmp_path / "0.toml"
    if count > MAX_CHAIN + 1:
        assert refused(library, first) == (
            f"{first}: extends more than {MAX_CHAIN} descriptions, one through another; join some of them"
        )
    elif circle:
        assert refused(library, first).endswith(f"-> {first}; break the circle")
    else:
        assert len(library.layers(first)) == count
