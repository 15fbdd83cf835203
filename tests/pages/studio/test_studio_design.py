"""Edits, what is refused, undo and redo, and files that change meanwhile."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.description.tables import Provenance
from layflat.errors import InputError
from layflat.pages.studio.design import MAX_UNDONE, Change, Design, error_text, open_description

WIDTH = "joint.large.hose.width"
OPENED = open_description("paper-arm")
EDITS = st.one_of(
    st.tuples(st.just(WIDTH), st.integers(120, 240).map(lambda x: f"{x} mm")),
    st.tuples(st.just("arm.payload"), st.integers(0, 5).map(lambda x: f"{x} kg")),
    st.tuples(st.just("joint.small.strap.layers"), st.integers(1, 4)),
    st.tuples(st.just("undo"), st.none()),
    st.tuples(st.just("redo"), st.none()),
    st.tuples(st.just("back"), st.none()),
)


@given(st.lists(EDITS, max_size=12))
def test_undo_and_redo_go_through_the_same_states(edits: list[tuple[str, object]]) -> None:
    design = Design(OPENED)
    states, at = [design.machine], 0
    for path, value in edits:
        if path == "undo":
            design.undo()
            at = max(0, at - 1)
        elif path == "redo":
            design.redo()
            at = min(len(states) - 1, at + 1)
        else:
            before = design.machine
            if path == "back":
                design.revert(WIDTH)
            else:
                design.edit(path, value)
            if design.machine != before:
                states, at = [*states[: at + 1], design.machine], at + 1
        assert design.machine == states[at]
        assert (design.can_undo, design.can_redo) == (at > 0, at < len(states) - 1)
        changed = {
            one
            for one in (WIDTH, "arm.payload", "joint.small.strap.layers")
            if design.opened_value(one) != design.value(one)
        }
        assert set(design.changes) == changed


def test_a_drag_is_one_edit(design: Design) -> None:
    for width in (161, 170, 180):
        design.edit(WIDTH, f"{width} mm", going_on=True)
    design.hold()
    design.edit(WIDTH, "190 mm", going_on=True)
    design.undo()
    assert design.value(WIDTH) == pytest.approx(0.18)
    design.undo()
    assert not design.changes


def test_history_is_bounded(design: Design) -> None:
    for i in range(MAX_UNDONE + 5):
        design.edit("arm.payload", f"{1 + i} kg")
    done = 0
    while design.can_undo:
        design.undo()
        done += 1
    assert done == MAX_UNDONE


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (WIDTH, "banana mm", "'banana mm' is not one number with one unit; give a length such as \"160 mm\""),
        (WIDTH, "-3 mm", "'-3 mm' is out of range; give at least 0.001 m"),
        (WIDTH, "3 kg", "'3 kg' is not a length; give a length such as \"160 mm\""),
        ("joint.large.strap.layers", "two", "'two' is not a whole number; give one such as 12"),
        ("joint.large.hose.contact_end", "130 deg", "joint.large.hose: contact_end must be smaller than wrap, for"),
    ],
)
def test_nonsense_is_refused_with_the_words_of_a_file(design: Design, path: str, value: object, said: str) -> None:
    before = design.machine
    with pytest.raises(InputError) as refused:
        design.edit(path, value)
    assert error_text(refused.value, path).startswith(said)
    assert design.machine == before
    assert not design.can_undo


def test_sources_tell_what_was_changed(design: Design) -> None:
    assert design.source(WIDTH) == Provenance("paper", "section 2.3")
    assert design.source("safety.speed") == Provenance("default")
    design.edit(WIDTH, "170 mm")
    assert design.source(WIDTH).source == "edited"
    design.edit_all({"arm.payload": Change("2 kg", Provenance("calibrated", "tuned"))})
    assert design.source("arm.payload") == Provenance("calibrated", "tuned")
    design.edit(WIDTH, "16 cm")
    assert WIDTH not in design.changes


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text('extends = "paper-arm"\nname = "mine"\n[arm]\npayload = "2 kg"\n')
    return path


def test_a_file_that_changes_is_seen_and_can_be_read_again(file: Path) -> None:
    design = Design(open_description(str(file)))
    design.edit(WIDTH, "170 mm")
    assert not design.opened.changed_on_disk()
    file.write_text(file.read_text().replace("2 kg", "3 kg"))
    assert design.opened.changed_on_disk() == [file.resolve()]
    assert design.value("arm.payload") == 2.0
    assert design.reload() == []
    assert (design.value("arm.payload"), design.value(WIDTH)) == (3.0, 0.17)
    assert not design.opened.changed_on_disk()


def test_changes_that_no_longer_go_with_a_file_are_named(file: Path) -> None:
    design = Design(open_description(str(file)))
    design.edit("joint.large.hose.contact_end", "110 deg")
    file.write_text(file.read_text() + '[joint.large.hose]\nwrap = "100 deg"\n')
    assert design.reload() == ["joint.large.hose.contact_end"]


def test_a_file_that_is_broken_meanwhile_leaves_the_design(file: Path) -> None:
    design = Design(open_description(str(file)))
    file.write_text("payload = ")
    with pytest.raises(InputError):
        design.reload()
    assert design.value("arm.payload") == 2.0
