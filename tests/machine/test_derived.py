"""Descriptions that a search wrote: what differs, laid over what they extend."""

from __future__ import annotations

from pathlib import Path

import pytest

from layflat.description.tables import Provenance
from layflat.errors import InputError, OutputError
from layflat.machine import load
from layflat.machine.listing import derived_path, nested_value, set_nested_value, write_derived

SMALL = "paper-small-joint"
SOURCE = Provenance("identified", "95 %: 1 to 2; from a log")


def test_what_is_written_is_loaded_and_all_else_stays(tmp_path: Path) -> None:
    path = derived_path(SMALL, tmp_path, "identified")
    assert path == tmp_path / "paper-small-joint-identified.toml"
    values = {"valve.conductance": "1.5 dm^3/(s bar)", "joint.small.losses.deflections.1": "3 deg"}
    found = write_derived(SMALL, "a title", values, dict.fromkeys(values, SOURCE), path)
    base = load(SMALL)
    assert (found.name, found.title) == (path.stem, "a title")
    assert found.valve is not None
    assert base.valve is not None
    assert found.valve.conductance == pytest.approx(1.5e-8)
    losses, before = found.joint["small"].losses, base.joint["small"].losses
    assert losses.deflections[1] == pytest.approx(0.0523599, rel=1e-5)
    assert losses.deflections[::2] == before.deflections[::2]
    assert found.provenance["valve.conductance"] == SOURCE
    assert found.provenance["joint.small.losses.deflections"] == SOURCE
    assert found.provenance["valve.overlap"] == base.provenance["valve.overlap"]
    assert found.model_copy(update={"name": "", "title": ""}).arm == base.arm
    assert load(path) == found


def test_a_derived_file_may_be_moved(tmp_path: Path) -> None:
    mine = tmp_path / "my-file.toml"
    mine.write_text(f'extends = "{SMALL}"\nname = "mine"\n[arm]\npayload = "1 kg"\n', encoding="utf-8")
    path = derived_path(str(mine), tmp_path / "out" / "deep", "tuned")
    assert path.name == "mine-tuned.toml"
    found = write_derived(str(mine), "t", {"arm.elbow": "80 deg"}, {"arm.elbow": SOURCE}, path)
    assert found.arm.payload == 1.0
    moved = path.rename(tmp_path / "moved.toml")
    mine.unlink()
    assert load(moved) == found
    assert load(moved).provenance == found.provenance
    assert found.provenance["valve.overlap"] == load(SMALL).provenance["valve.overlap"]


def test_the_base_is_not_overwritten(tmp_path: Path) -> None:
    mine = tmp_path / "a-tuned.toml"
    mine.write_text(f'extends = "{SMALL}"\nname = "a"\n', encoding="utf-8")
    above = tmp_path / "above.toml"
    above.write_text('extends = "a-tuned.toml"\n', encoding="utf-8")
    for given in (mine, above):
        with pytest.raises(InputError, match=r"a-tuned.toml: would be overwritten by what is derived from it"):
            derived_path(str(given), tmp_path, "tuned")
    assert derived_path(str(mine), tmp_path / "out", "tuned").parent.name == "out"
    with pytest.raises(OutputError):
        write_derived(SMALL, "t", {}, {}, mine / "b.toml")


def test_items_of_lists() -> None:
    base = {"a": {"list": [1, 2, 3], "b": 4}}
    plain: dict[str, object] = {}
    assert set_nested_value(plain, base, "a.list.1", 20) == "a.list"
    assert set_nested_value(plain, base, "a.list.2", 30) == "a.list"
    assert set_nested_value(plain, base, "a.c.d", "x") == "a.c.d"
    assert plain == {"a": {"list": [1, 20, 30], "c": {"d": "x"}}}
    assert base == {"a": {"list": [1, 2, 3], "b": 4}}
    assert nested_value(base, ["a", "list", "0"]) == 1
    assert nested_value(base, ["a", "nothing", "0"]) is None
