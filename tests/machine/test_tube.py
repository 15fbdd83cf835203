import re
from math import inf, radians
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from layflat.cli import app
from layflat.errors import InputError, MachineError
from layflat.identify.benches.moving.blocks import machine_unknowns
from layflat.machine import Machine, load, parameters
from layflat.machine.stale import tubes_counted_twice
from layflat.physics.air_balance import AirEstimate, AirObserverParameters, update_air_estimate
from layflat.physics.line import NoLine
from layflat.sim import Scenario, rollout
from layflat.sim.ensemble import ensemble

LINE = 'length = "1 m"\nbore = "4 mm"'


def made(folder: Path, text: str, base: str = "paper-arm-fast") -> Machine:
    file = folder / "mine.toml"
    file.write_text(f'extends = "{base}"\nname = "mine"\n{text}\n', encoding="utf-8")
    return load(file)


PAGE = Path(__file__).parents[2] / "docs" / "lines.md"


def test_the_pages_example_is_a_description(tmp_path: Path) -> None:
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    machine = made(tmp_path, text)
    assert machine.lines["large"] == machine.line
    assert machine.lines["small"] == machine.joint["small"].line


def test_without_a_word_there_is_none() -> None:
    arm = load("paper-arm-fast")
    assert all(joint.hose_a.line == joint.hose_b.line == NoLine() for joint in parameters.joints(arm))
    assert parameters.air_observer_parameters(arm, "small").line_conductance == inf
    assert tubes_counted_twice(arm) == []


def test_a_tube_has_volume_resistance_and_delay(tmp_path: Path) -> None:
    plain, machine = load("paper-arm-fast"), made(tmp_path, f"[line]\n{LINE}")
    for before, joint in zip(parameters.joints(plain), parameters.joints(machine), strict=True):
        line = joint.hose_a.line
        assert joint.hose_b.line == line
        assert line.conductance == pytest.approx(1.2e-8, rel=0.01)
        assert line.critical_ratio == pytest.approx(0.35, abs=0.01)
        added = line.volume + joint.hose_a.chamber.dead_volume - before.hose_a.chamber.dead_volume
        assert added == pytest.approx(np.pi / 4 * 0.004**2, rel=1e-9)
        assert joint.valve.delay == pytest.approx(1.0 / 343.2, rel=1e-3)
    parts = parameters.air_observer_parameters(machine, "small")
    assert parts.dead_volume == pytest.approx(60e-6 + 12.57e-6, rel=1e-3)
    assert parts.line_conductance == parameters.joints(machine)[1].hose_a.line.conductance


def test_what_is_given_is_taken_and_a_joint_may_have_its_own(tmp_path: Path) -> None:
    own = 'length = "2 m"\nbore = "6 mm"\nconductance = "3 dm^3/(s bar)"\ncritical_ratio = 0.4\ndelay = "1 ms"'
    machine = made(tmp_path, f'[line]\n{LINE}\n[joint.small.line]\n{own}\nwall_conductance = "0.2 W/K"')
    large, small = (joint.hose_a.line for joint in parameters.joints(machine))
    assert large.conductance == pytest.approx(1.2e-8, rel=0.01)
    assert small[1:3] == pytest.approx((3e-8, 0.4))
    assert small.wall_conductance == pytest.approx(0.1)
    assert parameters.joints(machine)[1].valve.delay == pytest.approx(1e-3)
    assert parameters.joints(machine)[0].valve.delay == pytest.approx(2.9e-3, rel=0.01)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"[line]\n{LINE}".replace("1 m", "30 m", 1), r"line\.length: '30 m' is out of range; give at most 20 m"),
        (f"[line]\n{LINE}".replace("4 mm", "4 m"), r"line\.bore: '4 m' is out of range"),
        ('[line]\nlength = "1 m"', r"line\.bore: is missing"),
        (f'[line]\n{LINE}\ndelay = "-1 ms"', r"line\.delay: '-1 ms' is out of range"),
        (f"[line]\n{LINE}\ncritical_ratio = 1.2", r"line\.critical_ratio: 1\.2 is out of range"),
        (f'[line]\n{LINE}\nconductance = "0 dm^3/(s bar)"', r"line\.conductance: .* is out of range"),
        (f"[line]\n{LINE}".replace("1 m", "6 m", 1), r"valve and line of joint 'large' .* three control cycles, 15 ms"),
        (f"[joint.large.line]\n{LINE}", r"joint 'small' has no line, but others have"),
    ],
)
def test_impossible_tubes_are_refused_in_one_line(tmp_path: Path, text: str, expected: str) -> None:
    with pytest.raises(MachineError, match=expected) as caught:
        made(tmp_path, text)
    assert "\n" not in str(caught.value)


def test_a_tube_that_is_counted_twice_is_noted(tmp_path: Path) -> None:
    made(tmp_path, f"[line]\n{LINE}")
    shown = CliRunner().invoke(app, ["machine", "check", str(tmp_path / "mine.toml")])
    assert shown.exit_code == 0
    assert "joint.small.hose.dead_volume" in shown.stdout
    parted = f'[joint.large.hose]\ndead_volume = "107 ml"\n[joint.small.hose]\ndead_volume = "47 ml"\n[line]\n{LINE}'
    assert tubes_counted_twice(made(tmp_path, parted)) == []


def test_a_line_can_be_fitted_where_there_is_one(tmp_path: Path) -> None:
    found = machine_unknowns(made(tmp_path, f"[line]\n{LINE}"), ["line"])
    assert [one.path for one in found] == ["line.length", "line.bore"]
    own = made(tmp_path, f"[line]\n{LINE}\n[joint.small.line]\n{LINE}")
    paths = [one.path for one in machine_unknowns(own, ["line"])]
    assert paths == ["line.length", "line.bore", "joint.small.line.length", "joint.small.line.bore"]
    with pytest.raises(InputError, match=r"paper-arm-fast: has no line; describe its \[line\]"):
        machine_unknowns(load("paper-arm-fast"), ["line"])


MOVES = Scenario(demand=[("0 s", ("-10 deg", "0 deg")), ("0.2 s", ("20 deg", "15 deg"))], duration="0.8 s")


@pytest.mark.compiled
def test_runs_of_an_ensemble_are_the_rollouts(tmp_path: Path) -> None:
    machine = made(tmp_path, f"[line]\n{LINE}")
    lengths = np.array([0.1, 1.0, 3.0])
    runs = ensemble(machine, MOVES, {"line.length": lengths}, traces=("angle", "pressure_a"))
    for i, length in enumerate(lengths):
        run = rollout(made(tmp_path, f"[line]\n{LINE}".replace("1 m", f"{length} m", 1)), scenario=MOVES)
        for name in ("angle", "pressure_a"):
            assert np.array_equal(runs[name].isel(run=i), run[name][:-1]), name
    assert not np.array_equal(runs["angle"][0], runs["angle"][2])


def most_amiss(run, machine: Machine, parts: AirObserverParameters) -> float:  # type: ignore[no-untyped-def]
    """Greatest residual of the watch over the small joint's air."""
    valve, air = machine.valve, machine.supply
    assert valve is not None
    before, worst = run.isel(time=0).sel(joint="small"), 0.0
    estimate = AirEstimate(float(before.pressure_a), float(before.pressure_b), float(before.angle), 0.0)
    joint = run.sel(joint="small")
    for k in range(1, run.sizes["time"]):
        opening = float(np.clip((joint.voltage[k - 1] - valve.centre_voltage) / valve.volts_to_full, -1.0, 1.0))
        gauge = float(joint.pressure_a[k] - joint.pressure_b[k])
        estimate = update_air_estimate(
            parts, estimate, opening, float(joint.angle[k]), gauge, air.pressure, air.ambient_pressure, machine.cycle
        )
        worst = max(worst, abs(estimate.residual))
    return worst


@pytest.mark.compiled
def test_the_watch_over_the_air_knows_the_tube(tmp_path: Path) -> None:
    machine = made(tmp_path, f"[line]\n{LINE}".replace("1 m", "3 m", 1).replace("4 mm", "3 mm"))
    run = rollout(machine, scenario=MOVES)
    assert np.ptp(run["angle"].sel(joint="small").values) > radians(10.0)
    knowing = parameters.air_observer_parameters(machine, "small")
    assert most_amiss(run, machine, knowing) < machine.safety.air_residual
    assert (
        most_amiss(run, machine, parameters.air_observer_parameters(load("paper-arm-fast"), "small"))
        > machine.safety.air_residual
    )
