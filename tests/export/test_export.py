"""What an export refuses, in one line each, and what its header says."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from layflat.errors import InputError, KindError, MachineError, OutputError
from layflat.export import TARGET_WRITERS, export
from layflat.export.c_interface import CInterface
from layflat.export.layout import c_name
from layflat.export.numbers import c_number
from layflat.files import write_text
from layflat.machine import Machine, load, names

PLAIN = """
from typing import Literal, NamedTuple

from layflat.control import CONTROL_LAWS, ControlKind, ControllerPart, voltages_alone


class PlainPart(ControllerPart):
    kind: Literal["exported-plain"]


class Plain(NamedTuple):
    centre: float  # V


class PlainReport(NamedTuple):
    error: float


def wake(settings, sensed):
    return (0.0,)


def step(settings, memory, sensed, demand, elapsed):
    voltage = tuple(settings.centre for _ in sensed.angle)
    return memory, voltages_alone(voltage), tuple(PlainReport(0.0) for _ in sensed.angle)


CONTROL_LAWS.register(ControlKind(
    name="exported-plain", description=PlainPart, parameters=lambda described, machine: Plain(5.0),
    parameter_types=(Plain,), wake=wake, step=step, report=PlainReport, signals={"error": ("rad", "none")},
))
"""


def message(machine: object, target: str = "c", out: Path = Path("unused"), **options: str) -> str:
    """The one line by which an export is refused."""
    with pytest.raises((InputError, KindError)) as refused:
        export(machine, target, out, **options)  # type: ignore[arg-type]
    text = str(refused.value)
    assert "\n" not in text
    assert not Path("unused").exists()
    return text


def test_an_unknown_target_names_the_known_ones() -> None:
    text = message("paper-arm", "abacus")
    assert all(name in text for name in TARGET_WRITERS)
    assert "did you mean 'cortex-m7'?" in message("paper-arm", "cortex-m8")


def test_a_folder_with_files_and_a_file_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert "is no empty folder" in message("paper-arm", out=tmp_path)
    assert "is no empty folder" in message("paper-arm", out=tmp_path / "notes.txt")
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize("fault", [OutputError("the disk is full"), KeyboardInterrupt()])
def test_a_failure_leaves_no_part_of_a_folder(
    fault: BaseException, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write(machine: Machine, folder: Path, **_: str) -> Iterator[Path]:
        yield write_text(folder / "lib" / f"{machine.name}.txt", "half")
        raise fault

    monkeypatch.setattr("layflat.export.c_folder.write_c_folder", write)
    for out in (tmp_path / "new", tmp_path):
        with pytest.raises(type(fault)):
            export("paper-arm", "c", out)
        assert list(tmp_path.iterdir()) == []


def test_an_unknown_precision_is_refused() -> None:
    assert "give double or single" in message("paper-arm", precision="half")


def test_a_machine_without_controller_is_refused() -> None:
    with pytest.raises(MachineError, match="rig-kevlar: has no"):
        export("rig-kevlar", "c", "unused")


def test_a_law_in_plain_python_says_what_would_make_it_a_law(tmp_path: Path) -> None:
    (tmp_path / "plain.py").write_text(PLAIN)
    lines = 'extends = "paper-small-joint"', 'name = "plain"', 'kinds = ["plain.py"]', "[controller]"
    (tmp_path / "plain.toml").write_text("\n".join((*lines, 'kind = "exported-plain"', 'cycle = "5 ms"')))
    refused = message(tmp_path / "plain.toml")
    assert "'exported-plain' is plain Python; it can't run in C; decorate its functions with layflat.jit.law" in refused


@pytest.mark.parametrize("gain", ["1e39", "1e-39"])
def test_numbers_out_of_the_range_of_single_precision_are_refused(gain: str, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = load("paper-arm")
    control = CInterface(machine, "double", plant=False).control
    far = control.settings.joints[1].far._replace(error_gain=float(gain))
    joints = (control.settings.joints[0], control.settings.joints[1]._replace(far=far))
    monkeypatch.setattr("layflat.export.entries.parameters.control", lambda _: control.settings._replace(joints=joints))
    text = message(machine, precision="single")
    assert "paper-arm" in text
    assert f"settings.joints[1].far.error_gain is {float(gain):g}, out of the range of single precision" in text
    assert "export in double precision" in text


@pytest.mark.parametrize("name", sorted(set(names()) - {"earlier-actuator"}))
def test_every_field_of_a_header_has_unit_and_meaning(name: str) -> None:
    machine = load(name)
    if machine.controller is None:
        pytest.skip("it has no controller")
    interface = CInterface(machine, "double", plant=True)
    bare = [
        f"{struct.name}.{field.name}"
        for struct in interface.api.structs()
        for field in struct.fields
        if field.struct is None and not field.comment
    ]
    assert bare == []


def test_a_header_holds_no_pointer_and_a_stack(tmp_path: Path) -> None:
    interface = CInterface(load("paper-arm"), "single", plant=False)
    text = interface.api.header("paper-arm", interface.constants({"control_step": 704}), interface.tables)
    assert re.search(r"#define PAPER_ARM_STACK_CONTROL_STEP 704 ", text)
    assert not re.search(r"\*", re.sub(r"/\*.*?\*/|\([^)]*\)", "", text, flags=re.DOTALL))
    assert " double " not in text


@pytest.mark.parametrize(("name", "prefix"), [("2-axis arm", "n2_axis_arm"), ("über", "ber"), ("default", "default_")])
def test_names_of_machines_become_names_of_c(name: str, prefix: str) -> None:
    assert c_name(name) == prefix


def test_numbers_are_read_back_to_their_bits() -> None:
    random = np.random.default_rng(0)
    for bits in random.integers(0, 2**63 - 2**52, 1000, dtype=np.uint64):
        value = float(bits.view(np.float64))
        if np.isfinite(value):
            assert float(c_number(value, "double")) == value
    for word in random.integers(0, 2**31 - 2**23, 1000, dtype=np.uint32):
        single = word.view(np.float32)
        if np.isfinite(single):
            assert np.float32(c_number(float(single), "float").removesuffix("f")) == single
