"""Members of clouds: named as machines are, and refused where the cloud was made for others."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat import __version__
from layflat.errors import MachineError
from layflat.machine import load
from layflat.machine.loader import MACHINE_LIBRARY, tables

COLUMNS: list[dict[str, Any]] = [
    {"machine": "paper-arm", "paths": ["valve.conductance"], "unit": "dm^3/(s bar)"},
    {"machine": "paper-arm", "paths": ["joint.large.hose.dead_volume", "joint.small.hose.dead_volume"], "unit": "ml"},
    {"machine": "paper-arm", "paths": ["joint.large.losses.deflections.0"], "unit": "deg"},
    {"machine": "earlier-actuator", "paths": ["joint.small.strap.loss_fraction"]},
]
MEMBERS = [[0.2, 100.0, 0.3, 0.05], [0.1, 70.0, 0.2, 0.07]]


def written(folder: Path, **other: Any) -> Path:
    bases = {name: MACHINE_LIBRARY.layers(name)[-1].plain for name in ("paper-arm", "earlier-actuator")}
    raw = {"layflat": __version__, "command": "make cloud", "columns": COLUMNS, "bases": bases, "members": MEMBERS}
    file = folder / "mine.cloud.json"
    file.write_text(json.dumps(raw | other), encoding="utf-8")
    return file


def test_a_member_is_the_machine_with_values_of_its_own(tmp_path: Path) -> None:
    file = written(tmp_path)
    base, member = load("paper-arm"), load(f"paper-arm@{file}:1")
    assert member.valve is not None
    assert member.valve.conductance == pytest.approx(0.1e-8)
    assert [joint.hose.dead_volume for joint in member.joint.values()] == pytest.approx([70e-6, 70e-6])
    now, before = (machine.joint["large"].losses.deflections for machine in (member, base))
    assert np.degrees(now[0]) == pytest.approx(0.2)
    assert now[1:] == before[1:]
    assert member.joint["small"].losses == base.joint["small"].losses
    assert member.controller == base.controller
    assert "member 1 of mine.cloud.json" in member.provenance["valve.conductance"].note


def test_what_extends_a_machine_has_its_members(tmp_path: Path) -> None:
    file = written(tmp_path)
    earlier = load(f"earlier-actuator@{file}:1")
    assert earlier.joint["small"].strap.loss_fraction == 0.07
    assert earlier.valve is not None
    assert earlier.valve.conductance == pytest.approx(0.1e-8)
    mine = tmp_path / "mine.toml"
    mine.write_text('extends = "paper-arm"\nname = "mine"\n[valve]\nconductance = "3 dm^3/(s bar)"\n', encoding="utf-8")
    above = load(f"{mine}@{file}:1")
    assert above.valve is not None
    assert above.valve.conductance == pytest.approx(3e-8)
    assert above.joint["large"] == load(f"paper-arm@{file}:1").joint["large"]
    mine.write_text(f'extends = "paper-arm@{file}:0"\nname = "mine"\n', encoding="utf-8")
    assert load(mine).valve == load(f"paper-arm@{file}:0").valve


def test_a_cloud_of_other_machines_is_refused_with_the_difference(tmp_path: Path) -> None:
    plain = MACHINE_LIBRARY.layers("paper-arm")[-1].plain
    supply = plain["supply"] | {"pressure_gauge": "5 bar"}
    file = written(tmp_path, bases={"paper-arm": plain | {"supply": supply}})
    with pytest.raises(MachineError, match=r"supply.pressure_gauge.*'5 bar', which has '4 bar' now.*make cloud"):
        load(f"paper-arm@{file}:0")
    # What members replace may differ.
    valve = plain["valve"] | {"conductance": "9 dm^3/(s bar)"}
    load(f"paper-arm@{written(tmp_path, bases={'paper-arm': plain | {'valve': valve}})}:0")


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"layflat": "0.0.1"}, f"was made with layflat 0.0.1, this is {__version__}"),
        ({"members": [[1.0]]}, "member 0 has 1 values for 4 columns"),
        ({"columns": [{"paths": 3}]}, "is no cloud of machines"),
        ({"members": 3}, "is no cloud of machines"),
    ],
)
def test_broken_clouds_are_refused(tmp_path: Path, other: dict[str, Any], said: str) -> None:
    with pytest.raises(MachineError, match=said.replace("(", r"\(")):
        load(f"paper-arm@{written(tmp_path, **other)}:0")


def test_names_that_are_none(tmp_path: Path) -> None:
    file = written(tmp_path)
    with pytest.raises(MachineError, match="has no member 2; give a number from 0 to 1"):
        load(f"paper-arm@{file}:2")
    with pytest.raises(MachineError, match="can't be read"):
        load(f"paper-arm@{tmp_path / 'none.json'}:0")
    with pytest.raises(MachineError, match="no such machine"):
        load(f"paper-arn@{file}:0")
    alone = tmp_path / "alone.toml"
    alone.write_text(MACHINE_LIBRARY.text("paper-arm"), encoding="utf-8")
    with pytest.raises(MachineError, match="is no machine of this cloud"):
        load(f"{alone}@{file}:0")
    assert tables("paper-arm")[0]["name"] == "paper-arm"
