"""Values that follow from others: derived where they are not given, told where they are stale."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from layflat.machine import Machine, changed, load, names
from layflat.machine.parts import body_mass
from layflat.machine.stale import stale_values

OMITTED = '["joint.large.link.centre", "joint.large.link.inertia", "joint.large.body.mass"]'


def mine(folder: Path, text: str, omits: str = "[]") -> Path:
    path = folder / "mine.toml"
    path.write_text(f'extends = "paper-arm"\nomits = {omits}\n{text}\n', encoding="utf-8")
    return path


def derived(folder: Path, text: str = "") -> Machine:
    return load(mine(folder, text, OMITTED))


def test_what_is_not_given_follows_from_the_sizes(tmp_path: Path) -> None:
    large = derived(tmp_path, '[joint.large.link]\nlength = "600 mm"\n').joint["large"]
    assert large.planar_link.centre == pytest.approx(0.3)
    assert large.planar_link.inertia == pytest.approx(0.6 * 0.6**2 / 12)
    assert large.body.mass == body_mass(large)


@pytest.mark.parametrize("name", ["large", "small"])
def test_the_papers_joints_weigh_what_follows_from_their_sizes(name: str) -> None:
    joint = load("paper-arm").joint[name]
    assert body_mass(joint) == pytest.approx(joint.body.mass, rel=0.05)


def test_derived_values_follow_a_change(tmp_path: Path) -> None:
    machine = derived(tmp_path)
    longer = changed(machine, "joint.large.link.length", "800 mm").joint["large"]
    assert longer.planar_link.centre == pytest.approx(0.4)
    wider = changed(machine, "joint.large.hose.width", 0.2).joint["large"]
    assert wider.body.mass > 1.1 * machine.joint["large"].body.mass
    given = changed(changed(machine, "joint.large.link.centre", 0.1), "joint.large.link.length", 0.8)
    assert given.joint["large"].planar_link.centre == 0.1
    assert changed(load("paper-arm"), "joint.large.link.length", 0.8).joint["large"].planar_link.centre == 0.2


def test_derived_values_follow_every_run_of_an_ensemble(tmp_path: Path) -> None:
    lengths = np.array([0.2, 0.4, 0.8])
    many = changed(derived(tmp_path), "joint.large.link.length", lengths).joint["large"].planar_link
    assert np.array_equal(many.centre, lengths / 2)
    assert np.array_equal(many.inertia, 0.6 * lengths**2 / 12)


def test_a_derived_machine_is_the_same_from_json(tmp_path: Path) -> None:
    machine = derived(tmp_path)
    assert Machine.model_validate_json(machine.model_dump_json()) == machine


@pytest.mark.parametrize("name", names())
def test_nothing_built_in_is_stale(name: str) -> None:
    assert stale_values(load(name)) == []


@pytest.mark.parametrize(
    ("text", "stale"),
    [
        ('[joint.large.link]\nlength = "600 mm"', ["link.centre", "link.inertia"]),
        ('[joint.large.link]\nlength = "600 mm"\ncentre = "300 mm"', ["link.inertia"]),
        ('[joint.large.link]\nlength = "400 mm"', []),
        ('[joint.large.link]\nmass = "2 kg"', ["link.inertia"]),
        ('[joint.large.hose]\nwidth = "220 mm"', ["body.mass"]),
        ('[joint.large.hose]\nwidth = "220 mm"\n[joint.large.body]\nmass = "7 kg"', []),
        ('[arm]\npayload = "1 kg"', []),
    ],
)
def test_what_no_longer_fits_is_told(tmp_path: Path, text: str, stale: list[str]) -> None:
    path = mine(tmp_path, text)
    assert [one.path for one in stale_values(load(path))] == [f"joint.large.{key}" for key in stale]


def test_a_copy_that_was_edited_is_told(tmp_path: Path) -> None:
    from layflat.machine.listing import to_toml
    from layflat.machine.loader import tables

    path = tmp_path / "copy.toml"
    text = to_toml(*tables("paper-arm"))
    before = text.index("[joint.large.link.length]\n")
    edited = text[:before] + text[before:].replace('"400 mm"', '"700 mm"', 1)
    path.write_text(edited, encoding="utf-8")
    found = stale_values(load(path))
    assert [one.path for one in found] == ["joint.large.link.centre", "joint.large.link.inertia"]
    assert "0.2 m is from before" in found[0].what
    assert "0.35 m" in found[0].right
