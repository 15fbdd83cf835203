"""`layflat migrate`: every row of the table of renamed keys, what stays of a file, and files that are refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
import tomli_w

from layflat.cell.file.loader import load as load_cell
from layflat.cli.migration import plan_migration
from layflat.description.change import changed_all
from layflat.description.renamed import EARLIER_KEYS, RENAMED_KEYS, with_former_keys, with_present_keys
from layflat.description.tables import parse_toml
from layflat.design.arm import read_task
from layflat.errors import InputError, LayflatError
from layflat.identify.benches.loader import load_bench
from layflat.machine import changed, load
from layflat.study import read_study
from tests.cli.commands import layflat, refused

if TYPE_CHECKING:
    from collections.abc import Callable

    from layflat.description.tables import Plain

STRIBECK = {"kind": "stribeck", "static_ratio": 1.3, "velocity": "0.1 rad/s", "drag": "0.1 N m", "load_ratio": 0.01}
SLIP = {"kind": "elasto-slip", "deflections": ["1 deg"], "weights": [1.0]}
SMOOTH = {"kind": "bouc-wen", "deflection": "1 deg"}
LOSSES = {"reference_pressure_gauge": "3 bar", "pressure_free": 0.2, "kind": "parallel"}
PARALLEL = LOSSES | {"parts": {"slip": SLIP, "smooth": SMOOTH}, "fractions": {"smooth": 0.3}}


def _machines() -> list[Any]:
    adjustable = {"valve.dither.min": 0.5, "joint.small.friction": STRIBECK, "joint.large.losses": PARALLEL}
    return [
        changed_all(load("paper-arm-adjustable"), adjustable),
        changed(load("earlier-actuator"), "controller.load_compensation", True),
        load("paper-arm-switching"),
        changed(load("picking-arm"), "controller.disabled", ("governor",)),
    ]


def _complete(described: Any) -> Plain:
    """A description with every key, without absent values, which TOML does not have."""

    def present(part: Any) -> Any:
        if isinstance(part, dict):
            return {key: present(value) for key, value in part.items() if value is not None}
        return [present(item) for item in part] if isinstance(part, list) else part

    plain: Plain = present(described.model_dump(mode="json"))
    return plain


def _cell(name: str) -> Plain:
    return _complete(load_cell(name)) | {"machine": "paper-arm"}


TASK = {"name": "a", "title": "", "payload": "1 kg", "supply": "6 bar", "reach": "0.9 m", "time": "1 s"}
MEMBERS = {"low": "1 bar", "high": "2 bar"}
STUDY = {
    "name": "a", "machine": "paper-arm", "sampling": "sobol", "runs": 8, "scenario": {"demand": "10 deg"},
    "vary": {"scenario.payload": {"mean": "1 kg", "std": "0.1 kg"}},
    "variant": [{"name": "a", "factors": {"valve": {"leakage": 2.0}}}],
}  # fmt: skip

FILES: list[tuple[str, Plain, Callable[[Path], Any]]] = [
    *(("machine", _complete(machine), load) for machine in _machines()),
    ("test bench", _complete(load_bench("friction-rig")), load_bench),
    ("cell", _cell("packing"), load_cell),
    ("cell", _cell("belt"), load_cell),
    ("arm task", TASK | {"rotation": "40 deg"}, read_task),
    ("arm task", TASK | {"joints": 1, "configurations": [["0 deg"], ["20 deg"]]}, read_task),
    ("study", STUDY, lambda path: read_study(path).canonical()),
]


@pytest.mark.parametrize(("noun", "plain", "read"), FILES)
def test_a_migrated_file_is_read_as_the_present_one(
    noun: str, plain: Plain, read: Callable[[Path], Any], tmp_path: Path
) -> None:
    path = tmp_path / "file.toml"
    path.write_text(tomli_w.dumps(plain), encoding="utf-8")
    expected = read(path)
    former = tomli_w.dumps(with_former_keys(noun, plain))
    path.write_text(former, encoding="utf-8")
    with pytest.raises(LayflatError, match=r"file\.toml: .*: is called .* now; `layflat migrate /.*` rewrites"):
        read(path)
    plan = plan_migration(path)
    plan.write()
    assert read(path) == expected
    assert plan_migration(path).renamed == []


def test_the_files_above_have_every_row() -> None:
    learnt = {"history": [{"most": 0.1, "landed": 0.2}]}
    former = [(noun, with_former_keys(noun, plain)) for noun, plain, _ in FILES] + [("learnt motion", learnt)]
    hit = {(noun, one.steps[-1], one.present) for noun, plain in former for one in with_present_keys(noun, plain)[1]}
    rows = {(noun, *row) for noun, tables in RENAMED_KEYS.items() for names in tables.values() for row in names.items()}
    assert rows == hit


@pytest.mark.parametrize("noun", RENAMED_KEYS)
def test_each_row_goes_both_ways(noun: str) -> None:
    """A table at the place of each row, with the kinds that it names."""
    for place, names in {**RENAMED_KEYS[noun], **EARLIER_KEYS.get(noun, {})}.items():
        plain: Plain = {}
        table = plain
        for step in place.split(".") if place else []:
            name, _, kind = step.partition("=")
            table = table.setdefault("x" if name == "*" else name, {"kind": kind} if kind else {})
        table |= dict.fromkeys(names, 1)
        present, renamed = with_present_keys(noun, plain)
        assert [one.present for one in renamed] == list(names.values())
        if place in RENAMED_KEYS[noun] and not names.keys() & EARLIER_KEYS.get(noun, {}).get(place, {}).keys():
            assert with_former_keys(noun, present) == plain


MINE = """\
# my arm
extends = "paper-arm-tracking"   # of the paper
name = "mine"
joint.large.hose.loss_share = { value = 0.12, source = "given", note = "loss_share = 1" } # loops

[controller]
  without = [ "governor",  # slow
              'friction' ]
"quickest" = "90 ms"

[joint.small]
strap = {loss_share=0.0} # none
[joint."small".hose]
loss_share = 0.1
"""


def test_comments_order_and_format_stay(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_bytes(b"\xef\xbb\xbf" + MINE.replace("\n", "\r\n").encode())
    path.chmod(0o640)
    link = tmp_path / "link.toml"
    link.symlink_to(path)
    done = layflat("migrate", str(link), cwd=tmp_path)
    assert done.returncode == 0
    assert f"{link}: joint.small.strap.loss_share -> loss_fraction\n" in done.stdout
    assert done.stdout.endswith(f"{link}: 5 names changed\n")
    expected = MINE.replace("loss_share =", "loss_fraction =", 1).replace("without", "disabled")
    expected = expected.replace("quickest", "min_duration").replace("{loss_share=", "{loss_fraction=")
    expected = expected.replace("\nloss_share =", "\nloss_fraction =")
    assert path.read_bytes() == b"\xef\xbb\xbf" + expected.replace("\n", "\r\n").encode()
    assert path.stat().st_mode & 0o777 == 0o640
    assert link.is_symlink()
    assert load(path).controller.disabled == ("governor", "friction")  # type: ignore[union-attr]
    assert sorted(one.name for one in tmp_path.iterdir()) == ["link.toml", "mine.toml"]
    before = path.stat()
    assert layflat("migrate", str(path)).stdout == f"{path}: nothing to rename\n"
    assert path.stat() == before


OLD_STUDY = """\
name = "mine"
machine = "mine.toml"
runs = 8

[scenario]
demand = "10 deg"

[vary."joint.small.hose.loss_share"]   # losses
mean = 0.1
deviation = 0.02
also = ["joint.large.hose.loss_share", 'joint.large.strap.loss_share']

[[variant]]
name = "as it is"

[[variant]]
name = "other"
set.joint.large.hose.loss_share = 0.2
times = { joint.small.hose.loss_share = 1.5 }

[variant.set.controller]
load_spread = 0.01
"""


def test_paths_and_parts_of_machines_in_a_study(tmp_path: Path) -> None:
    study, machine = tmp_path / "study.toml", tmp_path / "mine.toml"
    study.write_text(OLD_STUDY, encoding="utf-8")
    machine.write_text(MINE, encoding="utf-8")
    dry = layflat("migrate", "--dry-run", str(study), str(machine))
    assert f"{study}: vary.joint.small.hose.loss_share.also.0 -> joint.large.hose.loss_fraction\n" in dry.stdout
    assert f"{study}: 8 names would change\n" in dry.stdout
    assert machine.read_text() == MINE
    assert layflat("migrate", str(study), str(machine)).returncode == 0
    described = read_study(study)
    assert [one.path for one in described.varied] == ["joint.small.hose.loss_fraction"]
    assert described.varied[0].also == ("joint.large.hose.loss_fraction", "joint.large.strap.loss_fraction")
    other = described.variants[1].machine
    assert other.joint["small"].hose.loss_fraction == pytest.approx(0.15)
    assert other.joint["large"].hose.loss_fraction == 0.2
    assert other.controller.load_std == 0.01  # type: ignore[union-attr]


def test_keys_of_earlier_versions(tmp_path: Path) -> None:
    cell, machine = tmp_path / "cell.toml", tmp_path / "machine.toml"
    cell.write_text(
        'extends = "packing"\nomits = ["pack.apples", "pack.mushrooms"]\n'
        '[pack.tomatoes]\nturn = "5 deg"\n[tray.infeed]\nturn = "-4 deg"\n[camera]\nturn = "3 deg"\n'
    )
    machine.write_text('extends = "paper-arm"\n[safety]\nsurplus = 0.3\n', encoding="utf-8")
    with pytest.raises(LayflatError, match=r"omits\.0: is called container\.apples now"):
        load_cell(cell)
    assert layflat("migrate", str(cell), str(machine)).returncode == 0
    assert set(load_cell(cell).container) == {"tomatoes"}
    assert load(machine).safety.air_residual == 0.3


def test_a_file_of_a_kind_that_its_base_names(tmp_path: Path) -> None:
    base, mine = tmp_path / "base.toml", tmp_path / "mine.toml"
    base.write_text('extends = "friction-rig"\nname = "base"\n', encoding="utf-8")
    mine.write_text('extends = "base.toml"\nfriction.film_share = 0.4\n', encoding="utf-8")
    assert layflat("migrate", str(mine)).returncode == 0
    assert load_bench(mine).friction.film_fraction == 0.4
    mine.write_text('extends = "base.toml"\nfriction.film = 0.4\n', encoding="utf-8")
    assert "friction.film: unknown key" in refused("migrate", str(mine))


def test_a_cloud_and_what_was_learnt(tmp_path: Path) -> None:
    columns = [{"machine": "earlier-actuator", "paths": ["joint.small.strap.loss_share"]}]
    base = {"joint": {"small": {"strap": {"loss_share": 0.07}}}}
    cloud = {"layflat": "0.1.0", "command": "x", "columns": columns, "bases": {"earlier-actuator": base}, "members": []}
    path = tmp_path / "a.cloud.json"
    path.write_text(json.dumps(cloud, indent=1), encoding="utf-8")
    assert layflat("migrate", str(path)).returncode == 0
    assert path.read_text() == json.dumps(cloud, indent=1).replace("loss_share", "loss_fraction")


UNCLEAR = [
    ("a = [", "is not TOML"),
    ("{ a", "is neither TOML nor JSON"),
    ('{"a": 1}', "is no file that layflat knows; give a machine"),
    ("red = 3\nsizes = 4\n", "is no file that layflat knows; give a machine"),
    ("", "is no file that layflat knows; give a machine"),
    (MINE + "[zebra]\n", "zebra: unknown key"),
    (MINE.replace("quickest", "quick"), "controller.quick: unknown key"),
    (MINE + "loss_fraction = 0.2\n", "joint.small.hose: has loss_share and loss_fraction, its new name; keep one"),
    (MINE.replace("controller]", "controler]"), "controler: unknown key; did you mean 'controller'?"),
    (OLD_STUDY.replace("load_spread", "load_sprea"), "set: controller.load_sprea: unknown"),
]


@pytest.mark.parametrize(("text", "said"), UNCLEAR)
def test_a_file_that_is_not_understood_stays(text: str, said: str, tmp_path: Path) -> None:
    path, good = tmp_path / "mine.toml", tmp_path / "good.toml"
    path.write_text(text, encoding="utf-8")
    good.write_text(MINE, encoding="utf-8")
    assert said in refused("migrate", str(good), str(path))
    assert (path.read_text(), good.read_text()) == (text, MINE)


def test_files_that_can_not_be_read_or_written(tmp_path: Path) -> None:
    assert "can't be read" in refused("migrate", str(tmp_path / "none.toml"))
    assert "is a folder" in refused("migrate", str(tmp_path))
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    assert "is not a text file" in refused("migrate", str(binary))


def test_an_unusual_spelling_is_left_to_hands(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    text = 'extends = "paper-arm"\njoint.large.hose."loss\\u005Fshare" = 0.1\n'
    path.write_text(text, encoding="utf-8")
    assert parse_toml(text, "", "")["joint"]["large"]["hose"] == {"loss_share": 0.1}
    with pytest.raises(InputError, match="in an unusual way; rename it by hand"):
        plan_migration(path)
