"""What is saved says only what differs, is accepted by `layflat machine check`, and stays in its folder."""

from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.description.tables import Provenance
from layflat.errors import InputError
from layflat.machine import load
from layflat.pages.studio.design import Change, Design, open_description
from layflat.pages.studio.saving import file_below, list_stale, save
from tests.cli.commands import layflat

WIDTH = "joint.large.hose.width"


def saved(design: Design, path: Path) -> str:
    """Save, check by the command, compare; return the text."""
    save(design, path)
    done = layflat("machine", "check", str(path))
    assert done.returncode == 0, done.stderr
    assert load(str(path)).model_copy(update={"name": design.machine.name}) == design.machine
    return path.read_text()


def test_a_file_says_only_what_differs(design: Design, tmp_path: Path) -> None:
    design.edit(WIDTH, "170 mm")
    design.edit("joint.small.losses.weights", [0.5, 0.3, 0.2])
    design.edit_all({"arm.payload": Change("2 kg", Provenance("calibrated", "tuned"))})
    text = saved(design, file_below(tmp_path, "sub/mine", ".toml"))
    assert text.startswith('extends = "paper-arm"\nname = "mine"\n')
    assert text.count("=") == 2 + 1 + 1 + 3
    assert load(str(tmp_path / "sub" / "mine.toml")).provenance["arm.payload"] == Provenance("calibrated", "tuned")


def test_a_saved_file_can_be_edited_and_saved_again(design: Design, tmp_path: Path) -> None:
    path = file_below(tmp_path, "mine", ".toml")
    design.edit(WIDTH, "170 mm")
    saved(design, path)
    again = Design(open_description(str(path)))
    again.edit("arm.payload", "2 kg")
    beside = saved(again, file_below(tmp_path, "other", ".toml"))
    assert 'extends = "mine.toml"' in beside
    assert "170" not in beside
    own = saved(again, path)
    assert 'extends = "paper-arm"' in own
    assert "170 mm" in own
    assert "2 kg" in own
    assert not again.opened.changed_on_disk()
    again.revert("arm.payload")
    assert load(str(save(again, file_below(tmp_path, "third", ".toml")))).arm.payload == 1.5


def test_what_was_opened_is_kept_when_it_changes_on_disk(design: Design, tmp_path: Path) -> None:
    path = save(design, file_below(tmp_path, "mine", ".toml"))
    opened = Design(open_description(str(path)))
    opened.edit(WIDTH, "170 mm")
    path.write_text('extends = "paper-small-joint"\nname = "mine"\n')
    assert "extends" not in saved(opened, file_below(tmp_path, "other", ".toml"))


def test_what_is_extended_is_not_overwritten(design: Design, tmp_path: Path) -> None:
    low = save(design, file_below(tmp_path, "low", ".toml"))
    design = Design(open_description(str(low)))
    high = save(design, file_below(tmp_path, "high", ".toml"))
    before = low.read_bytes()
    with pytest.raises(InputError, match="this design extends"):
        save(Design(open_description(str(high))), low)
    assert low.read_bytes() == before


@pytest.mark.parametrize(
    "name", ["", "  ", "../x", "/etc/x", "~/x", "a/../../b", "a//b", "C:\\x", "a\\b", ".x", "con", "a\nb", "x" * 300]
)
def test_names_that_lead_elsewhere_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError):
        file_below(tmp_path, name, ".toml")


@given(st.text(max_size=12))
def test_no_name_leads_out_of_the_folder(name: str) -> None:
    root = Path("/somewhere/below")
    with suppress(InputError):
        assert file_below(root, name, ".toml").is_relative_to(root)


def test_links_do_not_lead_out_of_the_folder(tmp_path: Path) -> None:
    root = tmp_path / "root"
    root.mkdir()
    (root / "away").symlink_to(tmp_path)
    (root / "file.toml").symlink_to(tmp_path / "file.toml")
    for name in ("away/x", "file"):
        with pytest.raises(InputError, match="by a link"):
            file_below(root, name, ".toml")


def test_values_that_are_from_before_are_found(design: Design) -> None:
    assert not list_stale(design)
    design.edit(WIDTH, "220 mm")
    assert [one.where for one in list_stale(design)] == ["joint.large.body.mass"]
