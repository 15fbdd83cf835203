"""Machines in WebAssembly: the numbers of the host, bit for bit, under Node.js."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layflat as lf
from layflat.errors import InputError
from layflat.export.web.folder import package_name, write_folder
from layflat.machine import load
from layflat.machine.exchanged import with_tracking
from tests.export.web.engines import run_text
from tests.export.web.traces import SECONDS, SEED, TRACED, check_same_bits, demands, node_trace

MACHINE = "paper-arm"
pytestmark = pytest.mark.compiled


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("web") / "arm"
    files = list(write_folder(load(MACHINE), folder, target="wasm", precision="double"))
    assert sorted(files) == sorted(folder.iterdir())
    return folder


@pytest.fixture
def beside(folder: Path, tmp_path: Path) -> Path:
    """A folder whose scripts import the machine as "../arm/index.js"."""
    place = folder.parent / tmp_path.name
    place.mkdir()
    return place


@pytest.mark.parametrize("law", ["paper", "tracking"])
def test_a_law_with_noise_is_the_rollout_to_the_bit(folder: Path, tmp_path: Path, law: str) -> None:
    """Brake, dither and supply included, of which the tracking law commands fractions."""
    machine = load(MACHINE)
    trace = node_trace(folder, tmp_path, machine, law)
    demand = dict(zip(machine.joints, demands(machine), strict=True))
    controlled = with_tracking(machine) if law == "tracking" else machine
    assert controlled is not None
    run = lf.rollout(controlled, demand, start=0.0, duration=SECONDS, seed=SEED)
    assert np.ptp(run["angle"].to_numpy()) > 0.3  # it moves
    for name in TRACED:
        check_same_bits(name, trace[name], run[name].to_numpy()[1:])
    check_same_bits("voltage", trace["voltage"], run["voltage"].to_numpy()[:-1])
    assert (np.ptp(trace["dither"]) > 0.5) == (law == "tracking")


def test_the_example_of_the_readme_runs(folder: Path, beside: Path) -> None:
    (text,) = re.findall(r"```js\n(.*?)```", (folder / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    angle = run_text(beside, text.replace('"./index.js"', '"../arm/index.js"'))
    assert angle == pytest.approx(0.35, abs=0.01)


def test_fields_are_where_the_description_has_them(folder: Path, beside: Path) -> None:
    machine = load(MACHINE)
    text = """
import { load } from "../arm/index.js";
const machine = await load(), plant = machine.plant(), controller = machine.controller("paper");
plant.parameters.around.payload = 2.5;
console.log(JSON.stringify({
  names: machine.joints, cycle: machine.cycle, around: plant.parameters.around.payload,
  brakes: plant.parameters.joints.map((joint) => joint.brake_torque), lengths: plant.parameters.arm.length_2,
  gain: controller.settings.joints[1].close.error_gain, keys: Object.keys(plant.parameters),
}));"""
    result = run_text(beside, text)
    assert result["names"] == list(machine.joints)
    assert result["cycle"] == machine.cycle
    assert result["around"] == 2.5
    assert result["brakes"] == [joint.brake.torque for joint in machine.joints.values()]
    assert result["lengths"] == machine.joint["small"].link.length  # type: ignore[union-attr]
    gains: Any = machine.joint["small"].gains
    assert result["gain"] == gains.close.error
    assert result["keys"] == ["arm", "joints", "around"]


def test_a_saved_state_goes_on_as_the_first_did(folder: Path, beside: Path) -> None:
    text = """
import { load, restore, save } from "../arm/index.js";
const machine = await load(), plant = machine.plant(), controller = machine.controller();
const run = (cycles) => {
  for (let k = 0; k < cycles; k++) { plant.drive(controller.step(plant.sample())); plant.advance(); }
};
controller.wake(plant.sample());
controller.demand.angle.set([0.5, -0.5]);
run(50);
const kept = [save(plant.state), save(controller.memory)];
run(50);
const first = [...save(plant.state)];
restore(plant.state, kept[0]);
restore(controller.memory, kept[1]);
run(50);
console.log(JSON.stringify({ first, second: [...save(plant.state)] }));"""
    result = run_text(beside, text)
    assert result["first"] == result["second"]


def test_many_plants_do_not_disturb_each_other(folder: Path, beside: Path) -> None:
    """Memory grows while others hold views of it."""
    text = """
import { load, save } from "../arm/index.js";
const machine = await load(), first = machine.plant(), before = machine.heap.memory.buffer.byteLength;
first.inputs[0].voltage = 8;
for (let i = 0; i < 400; i++) machine.plant().advance(3);
first.advance();
const alone = (await load()).plant();
alone.inputs[0].voltage = 8;
alone.advance();
const grown = machine.heap.memory.buffer.byteLength - before;
console.log(JSON.stringify({ grown, first: [...save(first.state)], alone: [...save(alone.state)] }));"""
    result = run_text(beside, text)
    assert result["grown"] > 0
    assert result["first"] == result["alone"]


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("machine.controller('papers')", 'paper-arm has no law "papers"; it has paper, tracking'),
        ("machine.controller().step(plant.sample())", "wake the controller at readings before its first step"),
        ("plant.inputs[1].load = NaN; plant.advance()", "the state of joint large became invalid"),
        ("plant.advance(1.5)", "advance takes a whole number of steps, not 1.5"),
        ("plant.rest([0])", "set takes 2 numbers, not 1"),
        ("restore(plant.state, [1, 2])", "numbers, not 2"),
    ],
)
def test_mistakes_say_what_would_be_right(folder: Path, beside: Path, code: str, message: str) -> None:
    text = f"""
import {{ load, restore }} from "../arm/index.js";
const machine = await load(), plant = machine.plant();
let message = "";
try {{ {code}; }} catch (error) {{ message = error.message; }}
console.log(JSON.stringify(message));"""
    assert message in run_text(beside, text)


def test_types_declare_every_field_with_its_unit(folder: Path) -> None:
    types = (folder / "index.d.ts").read_text(encoding="utf-8")
    assert "@" not in types.replace("@ts", "")
    declared = set(re.findall(r"^export interface (\w+)", types, re.MULTILINE))
    used = set(re.findall(r": (?:readonly )?((?:Plant|Paper|Tracking)\w+)", types))
    assert used <= declared
    assert re.search(r"/\*\* absolute, Pa; NAN: those that hold the arm \*/\n {2}readonly pressure_a: Row;", types)


def test_the_package_names_its_files(folder: Path) -> None:
    package = json.loads((folder / "package.json").read_text(encoding="utf-8"))
    assert package["name"] == "layflat-paper-arm"
    for place in (package["exports"]["."]["types"], package["exports"]["."]["default"], "./paper-arm.wasm"):
        assert (folder / place).is_file()


@pytest.mark.parametrize(
    ("name", "package"), [("Lift (95 deg)", "layflat-lift-95-deg"), ("2-axis über", "layflat-2-axis-ber")]
)
def test_names_of_packages_are_parts_of_addresses(name: str, package: str) -> None:
    assert package_name(name) == package


def test_single_precision_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"precision: 'single' is no precision of the target wasm; give \"double\""):
        list(write_folder(load(MACHINE), tmp_path / "out", target="wasm", precision="single"))
