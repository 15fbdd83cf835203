"""What was found, as a file: values come back, units stay, sources say how sure they are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.arrays import Array
from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.identify import Fit, Model, ModelOutput, Unknown
from layflat.identify.benches.loader import load_bench, load_description
from layflat.identify.benches.moving.blocks import MACHINE_BLOCKS, machine_unknowns
from layflat.identify.benches.rod.description import RodBench
from layflat.identify.fit import FittedParameter
from layflat.identify.identified_file import identified_path, write_identified
from layflat.machine import Machine, load
from layflat.machine.loader import BENCH_LIBRARY, tables

SMALL = load("paper-small-joint")
SHARES = st.floats(0.02, 0.98)


class Nothing(Model):
    """A model that was fitted to one sample."""

    def __init__(self, sought: tuple[Unknown, ...]) -> None:
        one = np.ones(1)
        self.unknowns = sought
        self.outputs = (ModelOutput("angle", "rad", "log", one, one, one > 0.0, 1.0),)

    def simulate(self, values: Array) -> Array:
        return np.ones((len(values), 1))


def found(sought: tuple[Unknown, ...], shares: list[float], *, sure: float = 0.01, at_bound: bool = False) -> Fit:
    """A fit that found values at shares of the way between the bounds."""
    estimates = []
    for one, share in zip(sought, shares, strict=True):
        value = one.low + share * (one.high - one.low)
        half = sure * (abs(value) if one.log else one.high - one.low)
        estimates.append(FittedParameter(one, value, value - half, value + half, at_bound))
    return Fit(Nothing(sought), tuple(estimates), np.ones(1), True, 1)


def small(fit: Fit, path: Path) -> Machine:
    """What was found of the small joint, from its file."""
    kept = write_identified("paper-small-joint", SMALL, fit, {"log": "ab" * 32}, path)
    assert isinstance(kept, Machine)
    return kept


ALL = tuple(machine_unknowns(SMALL, [block for block in MACHINE_BLOCKS if block != "line"]))


@settings(max_examples=15)
@given(st.lists(SHARES, min_size=len(ALL), max_size=len(ALL)))
def test_values_come_back_to_six_digits(tmp_path_factory: pytest.TempPathFactory, shares: list[float]) -> None:
    folder = tmp_path_factory.mktemp("out")
    fit = found(ALL, shares)
    path = identified_path("paper-small-joint", SMALL, folder)
    kept = small(fit, path)
    for estimate in fit.estimates:
        unknown = estimate.unknown
        near = 1e-6 * max(abs(estimate.value), 1e-3 * (unknown.high - unknown.low))
        assert value_at(kept, unknown.path) == pytest.approx(estimate.value, abs=near), unknown.path
    assert load(path) == kept


def test_units_of_the_base_are_kept_and_sources_say_how_sure(tmp_path: Path) -> None:
    sought = tuple(machine_unknowns(SMALL, ["valve", "friction"]))
    path = identified_path("paper-small-joint", SMALL, tmp_path)
    kept = small(found(sought, [0.4] * len(sought)), path)
    before, after = tables("paper-small-joint")[0], tables(path)[0]
    for section, key in (("valve", "conductance"), ("valve", "natural_frequency")):
        assert after[section][key].partition(" ")[2] == before[section][key].partition(" ")[2]
    assert "m^3" not in path.read_text(encoding="utf-8").replace("dm^3", "")
    source = kept.provenance["valve.conductance"]
    assert source.source == "identified"
    assert source.note.endswith("from log (sha256 abababababababab)")
    low, high = (float(end) for end in source.note.removeprefix("95 %: ").partition(";")[0].split(" to "))
    assert low < float(after["valve"]["conductance"].partition(" ")[0]) < high


def test_what_is_not_identifiable_and_what_is_at_a_bound_are_marked(tmp_path: Path) -> None:
    sought = tuple(machine_unknowns(SMALL, ["friction"]))
    vague = small(found(sought, [0.5, 0.5], sure=0.6), tmp_path / "vague.toml")
    assert vague.provenance["joint.small.brake.torque"].source == "assumed"
    assert vague.provenance["joint.small.brake.torque"].note.startswith("not identifiable from log")
    assert vague.title.endswith(", identified")
    ended = small(found(sought, [0.5, 0.5], at_bound=True), tmp_path / "end.toml")
    assert ended.title.startswith("not to be trusted: ")
    assert ended.provenance["joint.small.brake.torque"].note.startswith("at its bound from log")


def test_links_of_an_arm_in_space_are_written_as_lists_that_say_how_sure_they_are(tmp_path: Path) -> None:
    arm = load("picking-arm")
    sought = tuple(one for one in machine_unknowns(arm, ["inertia"]) if ".elbow." in one.path)
    fit = found(sought, [0.5] * len(sought))
    vague = {"arm.link.elbow.centre.1", "arm.link.elbow.mass"}
    doubted = tuple(
        replace(one, low=one.unknown.low, high=one.unknown.high) if one.unknown.path in vague else one
        for one in fit.estimates
    )
    path = identified_path("picking-arm", arm, tmp_path)
    kept = write_identified("picking-arm", arm, replace(fit, estimates=doubted), {"log": "ab" * 32}, path)
    assert isinstance(kept, Machine)
    sources = {name: kept.provenance[f"arm.link.elbow.{name}"] for name in ("mass", "centre", "inertia")}
    assert [sources[name].source for name in ("mass", "centre", "inertia")] == ["assumed", "assumed", "identified"]
    assert sources["centre"].note.startswith("only 2 of 3 identifiable from log")
    assert sources["inertia"].note.count(" to ") == 3
    assert load(path) == kept


def test_a_value_that_misses_zero_by_rounding_is_zero(tmp_path: Path) -> None:
    brake = next(one for one in ALL if one.path == "joint.small.brake.torque")
    sought = (replace(brake, low=0.0, log=False),)
    machine = small(found(sought, [8.7e-14 / brake.high]), tmp_path / "friction-free.toml")
    assert machine.joint["small"].brake.torque == 0.0


@pytest.mark.parametrize("name", BENCH_LIBRARY.names)
def test_a_bench_is_written_whole(name: str, tmp_path: Path) -> None:
    path = {
        "blow-down-vessel": "path.conductance", "friction-rig": "piston.area", "regulated-elbow": "chamber.volume",
    }[name]  # fmt: skip
    rig = load_bench(name)
    value = value_at(rig, path)
    sought = (
        Unknown(path, "m^3/(s Pa)" if "con" in path else "m^2" if "area" in path else "m^3", value, 0.0, 3 * value),
    )
    out = identified_path(name, rig, tmp_path)
    kept = write_identified(name, rig, found(sought, [0.5]), {"log": "ab" * 32}, out)
    assert value_at(cast(Any, kept), path) == pytest.approx(1.5 * value, rel=1e-6)
    assert type(load_description(str(out))) is type(rig)


def test_all_that_a_rod_bench_follows_from_a_fit_has_its_unit(tmp_path: Path) -> None:
    """Ends of the profile are not fitted but follow from the logs; a deflection of 6e-10 m makes no sense."""

    class Spread(Nothing):
        def described_values(self, values: Array) -> dict[str, float]:
            return super().described_values(values) | {
                "friction.profile_from": -5.99e-10,
                "friction.profile_to": 0.0412,
            }

    rig = load_bench("friction-rig")
    sought = (Unknown("friction.deflections.0", "m", 1e-5, 1e-11, 1e-1),)
    fit = found(sought, [0.5])
    small = replace(fit.estimates[0], value=5.99e-10)
    out = identified_path("friction-rig", rig, tmp_path)
    kept = write_identified(
        "friction-rig", rig, replace(fit, model=Spread(sought), estimates=(small,)), {"log": "ab" * 32}, out
    )
    assert isinstance(kept, RodBench)
    assert kept.friction.profile_from == 0.0
    assert kept.friction.profile_to == pytest.approx(0.0412)
    assert kept.friction.deflections[0] == pytest.approx(1e-9)
    assert "found was 5.99e-07 mm, which no description holds" in out.read_text(encoding="utf-8")


def test_what_no_description_can_hold_replaces_nothing(tmp_path: Path) -> None:
    rig = load_bench("regulated-elbow")
    sought = (Unknown("chamber.volume", "m^3", 2e-5, 1e-6, 1e-3),)
    out = identified_path("regulated-elbow", rig, tmp_path)
    out.write_text("earlier", encoding="utf-8")
    with pytest.raises(InputError, match=r"regulated-elbow-identified.toml: chamber.volume|volume is less"):
        write_identified("regulated-elbow", rig, found(sought, [0.0]), {"log": "ab" * 32}, out)
    assert out.read_text(encoding="utf-8") == "earlier"
    assert [path.name for path in tmp_path.iterdir()] == [out.name]
