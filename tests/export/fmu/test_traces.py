"""FMUs repeat simulation runs bit for bit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.physics.step import STEP
from layflat.sim.plant import SteppedPlant
from layflat.sim.results import Run
from tests.export.fmu.importer import OK, Fmu, Instance
from tests.export.fmu.runs import CYCLE, JOINTS, RECORDED, REPORT, SEED, follow, names_of, rows_of, run_of

pytestmark = pytest.mark.compiled


@pytest.fixture(scope="module", params=[False, True], ids=["quiet", "noisy"])
def noise(request: pytest.FixtureRequest) -> bool:
    return bool(request.param)


@pytest.fixture(scope="module")
def run(noise: bool) -> Run:
    return run_of(noise)


def begun(fmu: Fmu, noise: bool, start: float = 0.0) -> Instance:
    instance = Instance(fmu)
    instance.set_noise(SEED, noise)
    return instance.begin(start)


def test_plant_and_control_law_repeat_a_run(fmus: dict[str, Fmu], run: Run, noise: bool) -> None:
    instance = begun(fmus["both"], noise)
    first = [instance.get(names_of(name)) for name in RECORDED if name != "voltage"]
    assert np.array_equal(first, [run[name].values[0] for name in RECORDED if name != "voltage"])
    signals = (*RECORDED, *REPORT)
    assert np.array_equal(follow(instance, run, ("demand",), signals), rows_of(run, signals))


def test_the_plant_alone_repeats_a_run_by_its_voltages(fmus: dict[str, Fmu], run: Run, noise: bool) -> None:
    signals = tuple(name for name in RECORDED if name != "voltage")
    instance = begun(fmus["plant"], noise)
    assert np.array_equal(follow(instance, run, ("voltage",), signals), rows_of(run, signals))


def test_the_control_law_alone_repeats_a_run_by_its_readings(fmus: dict[str, Fmu], run: Run) -> None:
    quiet = run_of(False)
    instance = Instance(fmus["controller"])
    for name in ("measured_angle", "measured_pressure"):  # at rest the law wakes by readings without noise
        assert instance.set(dict(zip(names_of(name), quiet[name].values[0].tolist(), strict=True))) == OK
    signals = ("voltage", *REPORT)
    inputs = ("measured_angle", "measured_pressure", "demand")
    assert np.array_equal(follow(instance.begin(), run, inputs, signals), rows_of(run, signals))


def test_plant_and_control_law_repeat_a_run_as_two_fmus(fmus: dict[str, Fmu], run: Run, noise: bool) -> None:
    plant, law, rows = Instance(fmus["plant"]), Instance(fmus["controller"]), []
    plant.set_noise(SEED, noise)
    readings = [*names_of("measured_angle"), *names_of("measured_pressure")]
    shares = ("brake_command", "dither_command", "supply_command")
    commands = [name for signal in ("voltage", *shares) for name in names_of(signal)]

    def connect(source: Instance, target: Instance, names: list[str]) -> None:
        assert target.set(dict(zip(names, source.get(names), strict=True))) == OK

    assert plant.initialize() == law.initialize() == OK
    connect(plant, law, readings)
    assert plant.call("ExitInitializationMode") == law.call("ExitInitializationMode") == OK
    for k in range(run.sizes["time"] - 1):
        connect(plant, law, readings)
        assert law.set(dict(zip(names_of("demand"), run["demand"].values[k].tolist(), strict=True))) == OK
        assert law.step(k * CYCLE, CYCLE) == OK
        connect(law, plant, commands)
        assert plant.step(k * CYCLE, CYCLE) == OK
        rows.append([plant.get(names_of(name)) for name in ("angle", "pressure_a")])
    assert np.array_equal(rows, rows_of(run, ("angle", "pressure_a")))


def test_the_plant_follows_a_stepped_plant(fmus: dict[str, Fmu]) -> None:
    """Other start angles, pressures, payload and supply; voltages at random."""
    start, pressures, rng = [0.3, -0.2], (3.1e5, 2.7e5), np.random.default_rng(5)
    plant = SteppedPlant(
        "paper-arm", start=dict(zip(JOINTS, start, strict=True)), pressures=pressures, seed=SEED, payload="0.7 kg"
    )
    plant.supply = 4.5e5
    instance = Instance(fmus["plant"])
    instance.set_noise(SEED, True)
    chosen = dict(zip(names_of("start"), start, strict=True)) | {"payload": 0.7, "supply": 4.5e5}
    for name, pressure in zip(("start_pressure_a", "start_pressure_b"), pressures, strict=True):
        chosen |= dict.fromkeys(names_of(name), pressure)
    assert instance.set(chosen) == OK
    instance.begin()
    for k in range(60):
        voltages, load = rng.uniform(3.5, 6.5, 2), rng.uniform(-1.0, 1.0, 2)
        measured = plant.sense()
        readings = [instance.get(names_of(name)) for name in ("measured_angle", "measured_pressure")]
        assert np.array_equal(readings, measured)
        plant.drive(voltages)
        plant.load[:] = load
        plant.advance((k + 1) * CYCLE)
        values = zip(names_of("voltage") + names_of("load"), [*voltages, *load], strict=True)
        assert instance.set(dict(values)) == OK
        assert instance.step(k * CYCLE, CYCLE) == OK
        assert instance.get(names_of("angle")) == plant.angles.tolist()
        assert instance.get(names_of("pressure_a")) == plant.pressures[:, 0].tolist()


@settings(max_examples=8)
@given(sizes=st.lists(st.integers(1, 25), min_size=1, max_size=12), start=st.sampled_from([0.0, 3.0, -1.5]))
def test_steps_of_any_size_lead_to_the_same_state(fmus: dict[str, Fmu], sizes: list[int], start: float) -> None:
    whole, parts = (begun(fmus["both"], True, start) for _ in range(2))
    for instance in (whole, parts):
        assert instance.set({"large.demand": 0.4, "payload": 0.5}) == OK
    time = start
    for size in sizes:
        assert parts.step(time, size * STEP) == OK, parts.messages
        time += size * STEP
    assert whole.step(start, time - start) == OK, whole.messages
    signals = [name for signal in (*RECORDED, *REPORT) for name in names_of(signal)]
    assert whole.get(signals) == parts.get(signals)
    for instance in (whole, parts):
        instance.free()


def test_a_stronger_brake_holds_the_joint(fmus: dict[str, Fmu]) -> None:
    angles = []
    for torque in (6.7, 1e3):
        instance = begun(fmus["both"], False)
        assert instance.set({"plant.large.brake_torque": torque, "large.demand": 0.6}) == OK
        assert instance.step(0.0, 0.3) == OK
        angles += instance.get(["large.angle"])
    assert abs(angles[0]) > 0.05
    assert abs(angles[1]) < 1e-6
