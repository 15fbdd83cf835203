"""Names that results bear: files of any operating system, in no other folder."""

from pathlib import Path

import pytest

from layflat.description.names import file_name, unused_name
from layflat.errors import InputError


@pytest.mark.parametrize("name", ["paper-arm", "My arm 2", "Gelenk_ü", "a.b", "v1.2+3"])
def test_names_that_files_can_bear(name: str, tmp_path: Path) -> None:
    (tmp_path / f"{file_name(name, 'name')}.toml").write_text("", encoding="utf-8")
    assert [path.name for path in tmp_path.iterdir()] == [f"{name}.toml"]


@pytest.mark.parametrize(
    "name",
    ["", " ", "/abs/path", "../evil", "..", ".", ".hidden", "-rf", "a\0b", "a\nb", "a\\b", "c:d", "a ", "nul", "LPT1.x",
     "a" * 101, "ü" * 60, "end.", "what?", "\x7f"],
)  # fmt: skip
def test_names_that_they_can_not(name: str) -> None:
    with pytest.raises(InputError, match=r"--name: .*begin with a letter"):
        file_name(name, "--name")


def test_a_name_that_is_used_gets_the_first_free_number() -> None:
    used = {"a", "a-2", "a-4"}
    assert [unused_name(name, used.__contains__) for name in ("a", "b", "a-2")] == ["a-3", "b", "a-2-2"]
