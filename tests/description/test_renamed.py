"""Old keys and paths outside of files: errors, and what the last version has written."""

import json
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from layflat.description.key_tokens import names_in
from layflat.description.renamed import RENAMED_KEYS, present_path
from layflat.errors import InputError, LayflatError
from layflat.machine import changed, load
from layflat.machine.model import build, restore
from layflat.motion.learning import begin_learning
from layflat.motion.learning.file import read_learnt, write_learnt
from layflat.sim import rollout
from layflat.sim.dataset import open_run, save_run
from layflat.sim.metrics import air_used, peak_tip_acceleration

TRACKING = load("paper-arm-tracking")


def of_last_version(text: str) -> str:
    """A machine's JSON as the last version wrote it; the same words stand for the same keys in this machine."""
    words = {"loss_fraction": "loss_share", "demand_step": "demand_lead", "fractions": "shares", "min": "least"}
    words |= {new: old for old, new in RENAMED_KEYS["machine"]["controller=tracking"].items()}
    for new, old in words.items():
        text = text.replace(f'"{new}":', f'"{old}":')
    return text


def test_a_run_of_the_last_version_opens(tmp_path: Path) -> None:
    run = rollout(TRACKING, [0.0, 0.1], duration=0.3)
    expected = air_used(run), peak_tip_acceleration(run)
    run.attrs["machine"] = of_last_version(run.attrs["machine"])
    assert '"loss_share":' in run.attrs["machine"]
    again = open_run(save_run(run, tmp_path / "run.nc"))
    assert (air_used(again), peak_tip_acceleration(again)) == expected
    assert restore(again.attrs["machine"]) == TRACKING


def test_a_machine_in_a_log_of_an_earlier_version() -> None:
    text = load("paper-arm").model_dump_json().replace('"air_residual"', '"surplus"')
    assert restore(text) == load("paper-arm")


def test_what_the_last_version_has_learnt_is_read(tmp_path: Path) -> None:
    rows = np.linspace(0.0, 0.1, 80)[:, None] * [1.0, -1.0]
    learnt = begin_learning(TRACKING, (rows, 0.0 * rows, 0.0 * rows))
    learnt = learnt.learn_from(learnt.demand().angles)
    path = write_learnt(learnt, tmp_path / "move.learnt")
    content = json.loads(path.read_text())
    (repeat,) = content["history"]
    content["history"] = [{"most": repeat.pop("max"), "landed": repeat.pop("arrival"), **repeat}]
    content["machine"]["sha256"] = sha256(of_last_version(TRACKING.model_dump_json()).encode()).hexdigest()
    path.write_text(json.dumps(content))
    assert list(map(asdict, read_learnt(path, TRACKING).history)) == list(map(asdict, learnt.history))
    with pytest.raises(InputError, match="was learnt with another description of paper-arm-tracking"):
        read_learnt(path, changed(TRACKING, "arm.payload", 1.0))


def test_an_old_path_says_the_new_one() -> None:
    with pytest.raises(InputError, match=r"joint.small.hose.loss_share: is called joint.small.hose.loss_fraction now"):
        changed(TRACKING, "joint.small.hose.loss_share", 0.1)
    with pytest.raises(InputError, match=r"controller\.quickest: is called controller.min_duration now"):
        changed(TRACKING, "controller.quickest", 0.1)
    with pytest.raises(InputError, match="'quickest' is not there"):  # the paper's law has no such number
        changed(load("paper-arm"), "controller.quickest", 0.1)


def test_an_old_key_in_tables_says_the_new_one() -> None:
    plain = TRACKING.model_dump(mode="json")
    plain["joint"]["large"]["hose"]["loss_share"] = plain["joint"]["large"]["hose"].pop("loss_fraction")
    with pytest.raises(LayflatError, match=r"mine: joint.large.hose.loss_share: is called loss_fraction now; use that"):
        build(plain, {}, "mine")


def test_a_key_of_a_users_kind_is_its_own(tmp_path: Path) -> None:
    """A name that only the package's kind has given up."""
    (tmp_path / "mine.toml").write_text('extends = "paper-arm"\n[controller]\nkind = "tracking"\nquickest = "1 s"\n')
    with pytest.raises(LayflatError, match="is called min_duration now"):
        load(tmp_path / "mine.toml")
    (tmp_path / "mine.toml").write_text('extends = "paper-arm"\n[controller]\nkind = "own"\nquickest = "1 s"\n')
    with pytest.raises(LayflatError, match="'own' is not a known kind"):
        load(tmp_path / "mine.toml")


def test_paths_of_any_kind_are_renamed() -> None:
    assert present_path("machine", "valve.dither.least") == "valve.dither.min"
    assert present_path("machine", "arm.link.elbow.shapes.0.turn") == "arm.link.elbow.shapes.0.rotation"
    assert present_path("machine", "arm.link.turn.mass") == "arm.link.turn.mass"  # a joint of that name
    assert present_path("cell", "pack.apples.turn") == "container.apples.rotation"
    assert present_path("study", "variant.0.set.safety.surplus") == "variant.0.set.safety.air_residual"


def test_names_of_a_file_are_found_where_they_stand() -> None:
    text = '''a."b c".d = 1.5 # x = 2
t = 12:30:01.5
m = """
[no]
x = 1 \\""" """
[[list]]
k = [{ x = "y", z = [1, 2,
  3] }, "p"]
[list.sub]
'q' = \'\'\'a = 1\'\'\'
[[list]]
[[list.deep]]
e = 1979-05-27 07:32:00
'''
    found = [(token.steps, text[token.start : token.end]) for token in names_in(text) if token.is_name]
    assert found == [
        (("a",), "a"), (("a", "b c"), '"b c"'), (("a", "b c", "d"), "d"), (("t",), "t"), (("m",), "m"),
        (("list",), "list"), (("list", 0, "k"), "k"), (("list", 0, "k", 0, "x"), "x"), (("list", 0, "k", 0, "z"), "z"),
        (("list", 0, "k", 1), '"p"'), (("list",), "list"), (("list", 0, "sub"), "sub"),
        (("list", 0, "sub", "q"), "'q'"), (("list",), "list"), (("list",), "list"), (("list", 1, "deep"), "deep"),
        (("list", 1, "deep", 0, "e"), "e"),
    ]  # fmt: skip
