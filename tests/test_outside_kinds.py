"""Kinds from outside the package: the examples of docs/kinds.md, as a user would use them."""

import json
import pickle
import re
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from layflat.control import CONTROL_LAWS, FULL_FRACTIONS, Command, ControlKind, Demand, Sensed
from layflat.control.checks import CycleClock, PlainStep
from layflat.description.change import value_at
from layflat.errors import KindError, LayflatError
from layflat.jit import cache
from layflat.kinds import KindTable
from layflat.machine import Machine, changed, load
from layflat.physics.valves import VALVE_KINDS
from layflat.sim import Scenario, rollout
from layflat.sim.ensemble import ensemble
from layflat.sim.metrics import tip_settling
from layflat.study import read_study, run_study, study_table
from layflat.study.folder import ChangedError

PAGE = Path(__file__).parents[1] / "docs" / "kinds.md"
LOSSES = 'reference_pressure_gauge = "4 bar"\npressure_free = 0.2'
DESCRIBED = {
    "relay": ('[controller]\nkind = "relay"\ncycle = "5 ms"\nlevel = "0.6 V"\ndead_band = "0.2 deg"'),
    "plain_relay": ('[controller]\nkind = "plain-relay"\ncycle = "5 ms"'),
    "quick_valve": (
        '[valve]\nkind = "quick"\nconductance = "1.99 dm^3/(s bar)"\ncritical_ratio = 0.3\n'
        'leakage = "0.008 dm^3/(s bar)"\ncentre_voltage = "5 V"\nvolts_to_full = "5 V"'
    ),
    "viscous": (f'[joint.small.losses]\nkind = "viscous"\nvelocity = "2 rad/s"\n{LOSSES}'),
    "fading": ('[joint.small.friction]\nkind = "fading"\nspeed = "20 rad/s"'),
    "sprung_arm": ('[arm]\nkind = "sprung"\njoints = ["small"]\npayload = "1 kg"\nspring = "0.1 N m/deg"'),
}
COMPILED = [name for name in DESCRIBED if name != "plain_relay"]
ALL = "all_kinds"  # a machine of all compiled kinds at once: its kernels are compiled once for all tests


def outside_machine(folder: Path, kinds: list[str], name: str = "outside") -> Path:
    """The file of a machine of some of the page's kinds, all of which are written beside it."""
    for block in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
        (folder / block.split("\n")[0].removeprefix("# ")).write_text(block, encoding="utf-8")
    files = json.dumps([f"{kind}.py" for kind in kinds])
    head = f'extends = "paper-small-joint-fast"\nname = "{name}"\nkinds = {files}'
    path = folder / f"{name}.toml"
    path.write_text("\n\n".join([head, *(DESCRIBED[kind] for kind in kinds), ""]), encoding="utf-8")
    return path


@contextmanager
def own_sources() -> Iterator[None]:
    """Kernels that are called later do not depend on what is loaded in between; they would all be compiled anew."""
    before = dict(cache._included), cache._digests
    yield
    cache._included, cache._digests = before


@pytest.fixture(scope="module", autouse=True)
def _own_sources() -> Iterator[None]:
    with own_sources():
        yield


@pytest.fixture(scope="module")
def examples(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page's examples as files, and a machine for each."""
    folder = tmp_path_factory.mktemp("kinds")
    for name in DESCRIBED:
        outside_machine(folder, [name], name)
    outside_machine(folder, COMPILED, ALL)
    return folder


@pytest.fixture(scope="module")
def machine(examples: Path) -> Machine:
    return load(examples / f"{ALL}.toml")


MOVE = Scenario(demand=[("0 s", "-5 deg"), ("0.1 s", "10 deg")], duration="0.6 s", noise=True, seed=3)


def test_compiled_kinds_run_alike_in_rollout_and_ensemble(machine: Machine) -> None:
    runs = ensemble(machine, MOVE, {"arm.payload": np.array([0.5, 1.0, 1.5])}, traces=("angle", "voltage"))
    for i, payload in enumerate((0.5, 1.0, 1.5)):
        run = rollout(changed(machine, "arm.payload", payload), scenario=MOVE)
        assert np.ptp(run["angle"].to_numpy()) > np.radians(5.0)
        for name in ("angle", "voltage"):
            assert np.array_equal(runs[name].isel(run=i), run[name][:-1]), name


STUDY = """
name = "tried"
machine = "{machine}.toml"
metrics = ["settling", "air_used"]

[scenario]
duration = "0.3 s"
demand = [["0 s", "-5 deg"], ["0.1 s", "10 deg"]]

[vary."{path}"]
relative = true
values = [0.5, 1.0]

[vary."scenario.payload"]
values = ["0.5 kg", "1 kg"]
"""
OWN_NUMBERS = {
    "relay": "controller.level",
    "quick_valve": "valve.conductance",
    "viscous": "joint.small.losses.velocity",
    "fading": "joint.small.friction.speed",
    "sprung_arm": "arm.spring",
}


@pytest.mark.parametrize("name", COMPILED)
def test_a_study_varies_the_numbers_of_a_kind(machine: Machine, name: str, examples: Path, tmp_path: Path) -> None:
    file = examples / f"{name}-study.toml"
    file.write_text(STUDY.format(machine=machine.name, path=OWN_NUMBERS[name]), encoding="utf-8")
    study = read_study(file)
    whole = run_study(study, tmp_path / "whole")
    found = study_table(tmp_path / "whole")
    usual = value_at(study.machine, OWN_NUMBERS[name])
    vary = {OWN_NUMBERS[name]: usual * found[OWN_NUMBERS[name]], "scenario.payload": found["scenario.payload"]}
    alone = ensemble(study.machine, study.scenarios[0], vary, precision=study.precision)
    assert np.array_equal(found["air_used"], alone["air_used"])
    assert found["air_used"].nunique() == 4
    run_study(read_study(file), tmp_path / "parts", chunk=3, threads=1)
    assert study_table(tmp_path / "parts").equals(found)
    before = whole.read_bytes()
    assert run_study(read_study(file), tmp_path / "whole").read_bytes() == before, "the folder knows its study again"


def test_a_study_is_another_one_with_other_laws_of_a_kind(machine: Machine, examples: Path, tmp_path: Path) -> None:
    """What the kind's file holds counts, not where it is."""
    file = examples / "again-study.toml"
    file.write_text(STUDY.format(machine=machine.name, path="controller.level"), encoding="utf-8")
    run_study(read_study(file), tmp_path)
    held = json.loads((tmp_path / "study.json").read_text(encoding="utf-8"))
    assert str(examples) not in json.dumps(held)
    now, held["made_with"]["relay.py"] = held["made_with"]["relay.py"], "0123"
    (tmp_path / "study.json").write_text(json.dumps(held), encoding="utf-8")
    with pytest.raises(ChangedError) as caught:
        run_study(read_study(file), tmp_path)
    assert caught.value.differences == [f"made_with.relay.py: 0123 -> {now}"]


def test_a_study_says_that_a_law_in_plain_python_can_not_run(examples: Path) -> None:
    file = examples / "plain-study.toml"
    text = STUDY.format(machine="plain_relay", path="joint.small.brake.torque")
    file.write_text(text, encoding="utf-8")
    with pytest.raises(KindError, match=r"'plain-relay' is plain Python; .*layflat\.jit\.law"):
        read_study(file)


def test_a_law_of_ones_own_is_compared_with_others(examples: Path) -> None:
    from layflat.experiments.beyond.comparison import TRACKING_LABEL, prepare_comparison

    compared = prepare_comparison(str(examples / "relay.toml"))
    assert list(compared.laws) == ["relay", TRACKING_LABEL]
    assert "steps, relay" in [name for name, _ in compared.stages()]
    with pytest.raises(KindError, match=r"'plain-relay' is plain Python; it can't run in comparisons"):
        prepare_comparison(str(examples / "plain_relay.toml"))


def test_a_law_of_ones_own_reports_under_its_own_names(machine: Machine) -> None:
    run = rollout(machine, scenario=MOVE)
    assert run["error"].attrs == {"units": "rad", "long_name": "demand less angle"}
    assert np.array_equal(run["error"][:-1], run["demand"][:-1] - run["measured_angle"][:-1])
    assert "phase" not in run
    assert set(np.round(np.unique(run["voltage"]), 6)) <= {4.4, 5.0, 5.6}


def test_a_law_in_plain_python_runs_in_a_rollout_and_is_refused_where_it_can_not(examples: Path) -> None:
    machine = load(examples / "plain_relay.toml")
    run = rollout(machine, scenario=MOVE)
    assert np.abs(run["angle"] - run["angle"][0]).max() > np.radians(5.0)
    with pytest.raises(KindError, match=r"'plain-relay' is plain Python; .*layflat\.jit\.law"):
        ensemble(machine, MOVE, {"seed": np.arange(3.0)})


def test_viscous_losses_vanish_when_slow_and_a_spring_draws_back(examples: Path) -> None:
    from layflat.sim.sweep import sweep

    slow = sweep(load(examples / "viscous.toml"), "small", 4e5, brake=0.0)
    assert slow.hysteresis == pytest.approx(0.0, abs=1e-12)
    sprung = load(examples / "sprung_arm.toml")
    even = ("4 bar", "4 bar")
    run = rollout(sprung, start="20 deg", opening=0.0, brake=0.0, pressures=even, duration="1 s")
    assert run["angle"][-1, 0] < np.radians(18.0)


def test_a_brake_that_fades_only_takes_energy(machine: Machine) -> None:
    run = rollout(machine, scenario=MOVE)
    assert np.all(np.diff(run["brake_heat"], axis=0) >= -1e-12)
    steady = changed(machine, "joint.small.friction.speed", 1e3)
    assert not np.array_equal(run["angle"], rollout(steady, scenario=MOVE)["angle"])


def test_other_processes_find_a_machines_kinds(machine: Machine) -> None:
    assert pickle.loads(pickle.dumps(machine)) == machine
    run = rollout(machine, scenario=MOVE)
    assert tip_settling(run, 0.1, 0.6, 1.0) == 0.0


def broken(folder: Path, name: str, old: str, new: str) -> str:
    """What is said of a machine whose kind is spoilt."""
    text = (folder / f"{name}.py").read_text(encoding="utf-8")
    assert old in text
    number = zlib.crc32(f"{old} {new}".encode())
    spoilt = folder / f"{name}-{number}.py"
    kind = re.search(r'kind: Literal\["(.*?)"\]', text)[1]  # type: ignore[index]
    fresh = f"{kind}-{number}"
    spoilt.write_text(text.replace(old, new).replace(f'"{kind}"', f'"{fresh}"'), encoding="utf-8")
    described = (folder / f"{name}.toml").read_text(encoding="utf-8")
    machine = spoilt.with_suffix(".toml")
    described = described.replace(f"{name}.py", spoilt.name).replace(f'"{kind}"', f'"{fresh}"')
    machine.write_text(described, encoding="utf-8")
    with own_sources(), pytest.raises(LayflatError) as caught:
        rollout(load(machine), "5 deg", duration="0.05 s")
    assert "\n" not in str(caught.value)
    assert spoilt.name in str(caught.value)
    return str(caught.value)


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("name", "old", "new", "said"),
    [
        ("relay", "        step=step,\n", "", "lacks step"),
        ("relay", "        step=step,\n", '        step=step,\n        gives_up="doubt",\n', "gives up by 'doubt'"),
        ("relay", 'signals={"error": ("rad", "demand less angle")}', "signals={}", "signal 'error' has no unit"),
        ("relay", 'kind: Literal["relay"]', 'kind: Literal["other"]', "does not bear its name"),
        (
            "relay",
            "    return Relay(machine",
            "    Relay = lambda *all: all\n    return Relay(machine",
            "yields tuple; give Relay",
        ),
        ("relay", "machine.valve.centre_voltage,", '"5 V",', "yields '5 V' among its numbers"),
        ("relay", "    error = demand - angle", "    error = demand.no_such - angle", "has no attribute 'no_such'"),
        ("relay", "described.level", "described.no_such", "AttributeError"),
        ("plain_relay", "    errors = [", "    1 / 0\n    errors = [", "ZeroDivisionError"),
        ("quick_valve", "    leakage: float\n", "", "lacks leakage"),
        ("quick_valve", "@law\ndef move", "def move", "move of kind"),
        ("sprung_arm", "joints=1", "joints=8", "no laws for one to 7 joints"),
        ("viscous", "import law", "import law, no_such", "ImportError"),
        ("viscous", "import law", "import law, (", "SyntaxError"),
        ("viscous", '"""Losses of', '"""\0Losses of', "null bytes"),
        ("viscous", '"""Losses of', 'raise SystemExit(0)\n"""Losses of', "SystemExit: 0"),
        ("viscous", "    return (state.torque,)", "    return state.torque", "not a tuple of torques"),
        ("viscous", "    return Torque(loss.damping * turn / h)", "    return None", "the state is None, not a Torque"),
        ("viscous", "lambda described, limit", "lambda described", "`parameters` of hysteresis .* fails: TypeError"),
        ("fading", "return brake / (", "return -brake / (", "-1 N m, which would drive the joint"),
        ("fading", "return brake / (", "return 1e999 * brake / (", "is nan, not a finite number"),
        ("fading", "plain=Fading(0.0)", "plain=0.0", "plain of kind .* is a float, not its parameters"),
        ("quick_valve", "    return Opening(0.0)", "    return Opening('x')", "opening of the state is the text 'x'"),
        ("quick_valve", "through(valve, command), ", "", "has 2 items, not 3"),
        ("sprung_arm", "(-arm.spring * q[0],)", "()", "the torques of angles has 0 items, not 1"),
        ("relay", "reports\n\n", "reports[:0]\n\n", "the report has 0 items, not 1"),
        (
            "relay",
            "    return Switches(memory.count",
            "    return tuple(memory), 1\n    return Switches(memory.count",
            "tuple of 2",
        ),
        ("relay", '("rad", "demand', '("furlong", "demand', "has the unit 'furlong', which is none"),
        (
            "plain_relay",
            "def wake(settings, sensed):",
            "def wake(settings):",
            "`wake` of control law .* fails: TypeError",
        ),
        ("plain_relay", "    return Cycles(0.0)", "    return None", "the memory is None"),
        ("plain_relay", "        step=step,", "        step=None,", "step of kind .* is no function"),
    ],
)
def test_a_kind_that_is_not_whole_or_fails_is_told_with_its_file(
    examples: Path, name: str, old: str, new: str, said: str
) -> None:
    told = broken(examples, name, old, new)
    assert said in told or re.search(said, told)


class Report(NamedTuple):
    error: float


class Cycles(NamedTuple):
    cycles: float


RETURNED = [
    ("[memory, command, reports]", "it is a list, not memory, command and report"),
    ("(memory, command)", "it is a tuple of 2"),
    ("None", "it is None"),
    ("(memory, voltages, reports)", "the command is a tuple of 1, not a Command"),
    ("(memory, command, ())", "the report has 0 items, not 1"),
    ("(memory, command, reports * 3)", "the report has 3 items, not 1"),
    ("(memory.cycles, command, reports)", "the memory is a float, not a Cycles as before"),
    ("(Report(1.0), command, reports)", "the memory is a Report, not a Cycles as before"),
    ("(memory, Command(list(voltages), command.shares), reports)", "`voltage` is a list"),
    ("(memory, Command((), ()), reports)", "`voltage` has 0 items, not 1"),
    ("(memory, Command(voltages * 2, command.shares), reports)", "`voltage` has 2 items, not 1"),
    ("(memory, Command(('5 V',), command.shares), reports)", "is the text '5 V', not a number"),
    ("(memory, Command((True,), command.shares), reports)", "is True, not a number"),
    ("(memory, Command((1j,), command.shares), reports)", "is 1j, not a number"),
    ("(memory, Command((1e999,), command.shares), reports)", "is inf, not a finite number"),
    ("(memory, Command((0.0 * 1e999,), command.shares), reports)", "is nan, not a finite number"),
    ("(memory, Command(voltages, (1.0,)), reports)", "an item of `shares` is a float, not a DriveFractions"),
    ("exit(0)", "fails: SystemExit: 0"),
    ("1 / 0", "fails: ZeroDivisionError"),
]


@pytest.mark.parametrize("late", [False, True], ids=["at once", "later"])
@pytest.mark.parametrize(("returned", "said"), RETURNED)
def test_what_a_plain_law_returns_is_checked_in_every_cycle(returned: str, said: str, late: bool) -> None:
    names: dict[str, Any] = {"Report": Report, "Cycles": Cycles, "Command": Command, "FULL_FRACTIONS": FULL_FRACTIONS}
    condition = "memory.cycles > 2.0" if late else "True"
    lines = [
        "def step(settings, memory, sensed, demand, elapsed):",
        "    memory, voltages, reports = Cycles(memory.cycles + 1.0), (5.0,), (Report(0.0),)",
        "    command = Command(voltages, (FULL_FRACTIONS,))",
        f"    return {returned} if {condition} else (memory, command, reports)",
    ]
    exec("\n".join(lines), names)
    step = PlainStep("tried", names["step"], names["Report"], CycleClock())
    nothing = (0.0,)
    memory = Cycles(0.0)
    good = 2 if late else 0
    for _ in range(good):
        memory, _, _ = step(None, memory, Sensed(nothing, nothing), Demand(*[nothing] * 4), 0.005)
    with pytest.raises(KindError) as caught:
        step(None, memory, Sensed(nothing, nothing), Demand(*[nothing] * 4), 0.005)
    assert str(caught.value).startswith("<string>:1: `step` of control law 'tried'")
    assert f"at {0.005 * good:g} s" in str(caught.value)
    assert said.removeprefix("fails") in str(caught.value)


def test_a_copy_under_another_name_is_the_same_kinds(examples: Path) -> None:
    """Machine code that is kept names the module of a kind's tuples: it goes by content, not by the file's name."""
    copy = examples / "copied.py"
    copy.write_bytes((examples / "plain_relay.py").read_bytes())
    text = (examples / "plain_relay.toml").read_text(encoding="utf-8")
    (examples / "copied.toml").write_text(text.replace("plain_relay.py", "copied.py"), encoding="utf-8")
    with own_sources():
        load(examples / "plain_relay.toml")
        load(examples / "copied.toml")
    module = CONTROL_LAWS.named("plain-relay").report.__module__
    assert module == f"layflat_kinds_{sha256(copy.read_bytes()).hexdigest()[:16]}"


def test_files_of_kinds_that_can_not_be_run(examples: Path) -> None:
    place = examples / "bad.toml"
    for named, said in (
        ('["gone.py"]', "gone.py can't be read"),
        ('"relay.py"', "is not a list of files"),
        ('["relay.toml"]', "is not a Python file"),
    ):
        place.write_text(f'extends = "paper-small-joint-fast"\nname = "bad"\nkinds = {named}\n', encoding="utf-8")
        with pytest.raises(LayflatError, match=said):
            load(place)


def test_an_unknown_kind_names_the_known_ones_and_the_nearest(examples: Path) -> None:
    place = examples / "unknown.toml"
    text = 'extends = "paper-small-joint-fast"\nname = "unknown"\n[controller]\nkind = "papper"\n'
    place.write_text(text, encoding="utf-8")
    with pytest.raises(LayflatError, match=r'controller\.kind: .papper. .*did you mean "paper"'):
        load(place)


def test_a_table_refuses_what_it_has() -> None:
    table: KindTable[ControlKind] = KindTable("control law", *CONTROL_LAWS)
    kind = CONTROL_LAWS.named("paper")
    with pytest.raises(KindError, match="there is a kind 'paper'"):
        table.register(kind)
    with pytest.raises(KindError, match="known kinds are"):
        VALVE_KINDS.named("magic")
