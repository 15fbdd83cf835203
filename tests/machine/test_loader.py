from pathlib import Path

import pytest

from layflat.errors import MachineError
from layflat.machine import load, names


def broken(tmp_path: Path, text: str, base: str = "paper-arm") -> str:
    path = tmp_path / "mine.toml"
    path.write_text(f'extends = "{base}"\n{text}\n', encoding="utf-8")
    with pytest.raises(MachineError) as caught:
        load(path)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(str(path))
    return message


@pytest.mark.parametrize("name", names())
def test_built_in_machines_load(name: str) -> None:
    machine = load(name)
    assert machine.name == name
    assert machine.title


@pytest.mark.parametrize("name", names())
def test_every_built_in_value_says_where_it_comes_from(name: str) -> None:
    machine = load(name)
    unsourced = [path for path, source in machine.provenance.items() if source.source == "given"]
    assert [path for path in unsourced if path not in {"name", "title"}] == []
    assert all(source.note for source in machine.provenance.values() if source.source != "given")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('[joint.large.hose]\nwith = "3 mm"', "joint.large.hose.with: unknown key; did you mean 'width'?"),
        ('[joint.large.hose]\nzebra = "3 mm"', "joint.large.hose.zebra: unknown key; known keys are width"),
        ("[joint.large.hose]\nwidth = 3", 'joint.large.hose.width: 3 is a bare number; give a length such as "160 mm"'),
        ('[joint.large.hose]\nwidth = "3"', "joint.large.hose.width: '3' is a bare number"),
        ('[joint.large.hose]\nwidth = "3 bar"', "joint.large.hose.width: '3 bar' is not a length"),
        ('[joint.large.hose]\nwidth = "3 pears"', "joint.large.hose.width: '3 pears' is not a number with a unit"),
        ('[joint.large.hose]\nwidth = "-3 mm"', "joint.large.hose.width: '-3 mm' is out of range"),
        ('[joint.large.hose]\nwidth = "0 mm"', "joint.large.hose.width: '0 mm' is out of range"),
        ('[joint.large.hose]\nwidth = "nan mm"', "joint.large.hose.width: 'nan mm' is not finite"),
        ("[joint.large.hose]\nwidth = true", "joint.large.hose.width: True is not a length"),
        (
            '[joint.large.hose]\nwrap = "190 deg"',
            "joint.large.hose.wrap: '190 deg' is over 180 deg; give an angle such as",
        ),
        ('[joint.large.hose]\ncontact_end = "130 deg"', "joint.large.hose: contact_end must be smaller than wrap"),
        ('[supply]\npressure_gauge = "-2 bar"', "supply.pressure_gauge: '-2 bar' is out of range"),
        ('[joint.large.hose]\nwidth = "20 mm"', "joint.large: hose.width is too small"),
        ("[joint.large.losses]\nweights = [0.5, 0.5, 0.5]", "joint.large.losses: weights must add up to 1"),
        ('[arm]\njoints = ["wrist"]', "arm.joints names the unknown joint 'wrist'"),
        ('[joint.large.hose]\nwidth = { value = "3 mm", src = "x" }', "joint.large.hose.width: unknown key 'src'"),
        ('[joint.large.hose]\nwidth = { value = "3 mm", source = "x" }', "source 'x' is unknown; use one of paper"),
        ("[valve]\ncritical_ratio = nan", "valve.critical_ratio: nan is not a finite number; give one such as 0.5"),
        ("[angle_sensor]\nbits = 2.5", "angle_sensor.bits: 2.5 is not a whole number"),
        ("[valve]\nfricton = 0.1", "valve.fricton: unknown key; did you mean 'friction'?"),
        ('[valve]\nkind = "magic"', """'magic' is not a known kind; known kinds are "spool", "switching\""""),
        ('[valve]\nkind = "switching"', "valve.frequency: is missing"),
        ("[joint", "is not TOML"),
    ],
)
def test_a_mistake_is_named_in_one_line(tmp_path: Path, text: str, expected: str) -> None:
    assert expected in broken(tmp_path, text)


def test_mistakes_in_a_valve_that_switches(tmp_path: Path) -> None:
    base = "paper-arm-switching"
    assert "valve.frequency: '3 m' is not a frequency" in broken(tmp_path, '[valve]\nfrequency = "3 m"', base)
    assert "valve: min_pulse must be shorter" in broken(tmp_path, '[valve]\nmin_pulse = "10 ms"', base)
    assert "valve.overlap: is missing" in broken(tmp_path, '[valve]\nkind = "spool"', base)


def test_missing_file_and_misspelt_name() -> None:
    with pytest.raises(MachineError, match="can't be read"):
        load("no/such/file.toml")
    with pytest.raises(MachineError, match="did you mean 'paper-arm'"):
        load("papr-arm")


def test_a_file_that_is_not_text(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(MachineError, match="not a text file"):
        load(path)


def test_a_missing_key_is_named(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('name = "x"\ntitle = "y"\n', encoding="utf-8")
    with pytest.raises(MachineError, match="supply: is missing"):
        load(path)


def test_extending_in_a_circle(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text('extends = "b.toml"\n', encoding="utf-8")
    (tmp_path / "b.toml").write_text('extends = "a.toml"\n', encoding="utf-8")
    with pytest.raises(MachineError, match="extends itself"):
        load(tmp_path / "a.toml")


def test_omitting_a_part(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('extends = "paper-arm"\nomits = ["valve"]\n', encoding="utf-8")
    mine = load(path)
    assert mine.valve is None
    assert not any(key.startswith("valve") for key in mine.provenance)


def test_omitting_what_is_not_there(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('extends = "paper-arm"\nomits = ["vlave"]\n', encoding="utf-8")
    with pytest.raises(MachineError, match="omits: 'vlave' is not there to omit"):
        load(path)


def test_what_is_laid_over_wins_and_the_rest_stays(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('extends = "paper-arm"\n[joint.large.hose]\nwidth = "200 mm"\n', encoding="utf-8")
    mine, paper = load(path), load("paper-arm")
    assert mine.joint["large"].hose.width == pytest.approx(0.2)
    assert mine.provenance["joint.large.hose.width"].source == "given"
    assert mine.joint["large"].hose.wrap == paper.joint["large"].hose.wrap
    assert mine.provenance["joint.large.hose.wrap"] == paper.provenance["joint.large.hose.wrap"]


@pytest.mark.parametrize(
    ("outputs", "said"),
    [
        ('["gripper", "gripper"]', "'gripper' is there twice"),
        (str([f"output {k}" for k in range(9)]), "interface.outputs"),
        ('["grip/per"]', "interface.outputs"),
        ('"gripper"', "interface.outputs"),
    ],
)
def test_outputs_that_can_not_be_are_told(tmp_path: Path, outputs: str, said: str) -> None:
    assert said in broken(tmp_path, f"[interface]\noutputs = {outputs}")
