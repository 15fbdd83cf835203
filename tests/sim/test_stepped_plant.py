from math import exp
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from layflat.control import Demand, Sensed, step, wake
from layflat.errors import DivergedError, InputError
from layflat.machine import Machine, changed, load, parameters
from layflat.physics.driven import BURST_TIME
from layflat.physics.step import STEP
from layflat.sim import Scenario, rollout
from layflat.sim.loop import Signals
from layflat.sim.plant import SteppedPlant
from layflat.sim.run import prepare_run
from tests.physics.controllers import Controller

SMALL, ARM = load("paper-small-joint-fast"), load("paper-arm-fast")
AMBIENT = SMALL.supply.ambient_pressure
EMPTY, FULL = (AMBIENT, AMBIENT), (3e5, 3e5)
CYCLE = 0.005
EVENTFUL = Scenario(
    demand=[(0.0, "25 deg"), (0.2, "-10 deg")],
    start=0.0,
    duration=0.4,
    seed=5,
    payload=[("0 s", "1 kg"), ("0.1 s", "2.5 kg")],
    supply=[("0 s", "4 bar"), ("0.15 s", "3 bar"), ("0.2 s", "4.5 bar")],
    load=[("0.12 s", "3 N m")],
)


def one_by_one(machine: Machine, acting: Signals, seed: int) -> dict[str, NDArray[np.float64]]:
    """What a loop in Python makes of what acts on a machine: columns by name, (instants, joints)."""
    plant, calm = (SteppedPlant(machine, start=0.0, seed=seed, noise=noisy) for noisy in (True, False))
    controller = Controller(parameters.control(machine), *calm.sense())
    demand, load, gauge, payload = (acting.named(name) for name in ("demand", "load", "supply", "payload"))
    supply = gauge + machine.supply.ambient_pressure
    rows, voltages, cycles = [], np.zeros(len(plant.joints)), len(acting.by_joint)
    for k in range(cycles + 1):
        angles, pressures = plant.sense()
        if k < cycles:
            voltages = controller.voltages(angles, pressures, CYCLE, demand[k])
        rows.append([plant.angles, plant.velocities, *plant.pressures.T, voltages.copy(), angles, pressures])
        if k < cycles:
            plant.payload, plant.supply, plant.load[:] = payload[k], supply[k], load[k]
            plant.drive(voltages)
            plant.advance(CYCLE * (k + 1))
    names = ("angle", "velocity", "pressure_a", "pressure_b", "voltage", "measured_angle", "measured_pressure")
    return dict(zip(names, np.array(rows).transpose(1, 0, 2), strict=True))


@pytest.mark.parametrize(
    "machine", [ARM, SMALL, changed(SMALL, "valve.delay", 7e-3)], ids=["arm", "small joint", "late valve"]
)
def test_driven_cycle_by_cycle_it_is_the_rollout_bit_for_bit(machine: Machine) -> None:
    run = rollout(machine, scenario=EVENTFUL)
    for name, column in one_by_one(machine, prepare_run(machine, EVENTFUL).signals, EVENTFUL.seed).items():
        assert np.array_equal(column, run[name].to_numpy()), name


@pytest.mark.parametrize(
    ("name", "stiffness", "cycles", "changing"),
    [("paper-arm-tracking", 0.0, 100, "dither"), ("paper-arm-adjustable", 20.0, 60, "supply")],
)
def test_what_a_law_commands_beside_voltages_acts_as_in_a_rollout(
    name: str, stiffness: float, cycles: int, changing: str
) -> None:
    """Fractions of brake, dither and supply, each cycle in two pieces."""
    goals, zeros, machine = (0.05, -0.04), (0.0, 0.0), load(name)
    demand = dict(zip(machine.joints, goals, strict=True))
    scenario = Scenario(demand=demand, demand_stiffness=stiffness, start=0.0, duration=cycles * CYCLE, noise=False)
    run, plant, settings = (
        rollout(machine, scenario=scenario),
        SteppedPlant(machine, noise=False),
        parameters.control(machine),
    )

    def readings() -> Sensed:
        return Sensed(*(tuple(row.tolist()) for row in plant.sense()))

    memory, shares = wake(settings, readings()), []
    for k in range(cycles):
        asked = Demand(goals, zeros, zeros, (stiffness, stiffness))
        memory, command, _ = step(settings, memory, readings(), asked, CYCLE)
        plant.drive(np.array(command.voltage), command.shares)
        plant.advance((k + 0.4) * CYCLE)
        plant.advance((k + 1) * CYCLE)
        shares.append([getattr(one, changing) for one in command.shares])
        assert np.array_equal(plant.angles, run["angle"].to_numpy()[k + 1]), k
        assert np.array_equal(plant.pressures[:, 0], run["pressure_a"].to_numpy()[k + 1]), k
    assert np.ptp(shares) > 0.5


@settings(max_examples=20)
@given(st.lists(st.floats(0.0, 0.03), max_size=8))
def test_in_however_many_pieces_time_passes(pieces: list[float]) -> None:
    whole, parted = (SteppedPlant(SMALL, start=0.0) for _ in range(2))
    for plant in (whole, parted):
        plant.drive(np.array([7.0]))
    time = 0.0
    for piece in pieces:
        time += piece
        parted.advance(time)
        assert time - STEP < parted.time <= time + 1e-9
    whole.advance(0.24)
    parted.advance(0.24)
    assert np.array_equal(whole.angles, parted.angles)
    assert np.array_equal(whole.pressures, parted.pressures)
    assert whole.angles[0] > 0.01


def test_time_does_not_go_back() -> None:
    plant = SteppedPlant(SMALL)
    plant.advance(0.1)
    plant.advance(0.05)
    assert plant.time == pytest.approx(0.1)


def test_without_air_it_rests() -> None:
    plant = SteppedPlant(ARM, start=(0.3, -0.4), pressures=EMPTY)
    plant.supply = AMBIENT
    plant.drive(np.array([10.0, 0.0]))
    plant.advance(60.0)
    assert plant.angles.tolist() == [0.3, -0.4]
    assert plant.velocities.tolist() == [0.0, 0.0]
    assert plant.pressures == pytest.approx(AMBIENT)


def late(cycles: int) -> SteppedPlant:
    """A plant without dither or noise whose valve is late by some cycles."""
    calm = changed(SMALL, "valve.dither.amplitude", 0.0)
    return SteppedPlant(changed(calm, "valve.delay", cycles * CYCLE), pressures=FULL, noise=False)


def test_a_held_voltage_comes_through_a_late_valve() -> None:
    plant = late(2)
    plant.drive(np.array([10.0]))
    plant.advance(2 * CYCLE)
    assert abs(plant.pressures[0, 0] - FULL[0]) < 500.0
    plant.advance(8 * CYCLE)
    assert plant.pressures[0, 0] > FULL[0] + 2e4


def test_who_drives_not_quite_to_the_instant_drives_once_a_cycle() -> None:
    exact, loose = late(2), late(2)
    for k in range(8):
        voltage = np.array([10.0 if k % 2 else 0.0])
        exact.advance(k * CYCLE)
        exact.drive(voltage)
        loose.advance(k * CYCLE + 0.5e-3)
        loose.drive(np.array([5.0]))
        loose.drive(voltage)
    exact.advance(8 * CYCLE)
    loose.advance(8 * CYCLE + 0.5e-3)
    assert loose.pressures == pytest.approx(exact.pressures, abs=200.0)
    assert np.ptp(exact.pressures) > 2e3


@pytest.mark.parametrize("hose", [0, 1])
def test_a_burst_hose_empties(hose: int) -> None:
    plant = SteppedPlant(SMALL, pressures=FULL)
    plant.load[0] = 0.0
    plant.burst(0, hose)
    plant.advance(BURST_TIME)
    left = (plant.pressures[0, hose] - AMBIENT) / (FULL[0] - AMBIENT)
    assert left == pytest.approx(exp(-1.0), rel=0.15)
    plant.advance(0.5)
    assert plant.pressures[0, hose] < AMBIENT + 2e4
    plant.burst(0, None)
    plant.drive(np.array([10.0 if hose == 0 else 0.0]))
    plant.advance(2.0)
    assert plant.pressures[0, hose] > AMBIENT + 2e5


def test_a_seized_valve_stays_and_is_let_go() -> None:
    plant = SteppedPlant(SMALL, pressures=FULL)
    plant.seize(0, 0.5)
    plant.drive(np.array([0.0]))
    plant.advance(0.5)
    assert np.array_equal(plant.pressures[0] > 3e5, [True, False])
    plant.seize(0, None)
    plant.advance(1.0)
    assert np.array_equal(plant.pressures[0] > 3e5, [False, True])


def test_a_seized_valve_lets_through_what_one_held_there_does() -> None:
    seized, held = late(0), late(0)
    for plant in (seized, held):
        plant.seize(0, 0.4)
    held.seize(0, None)
    seized.drive(np.array([0.0]))
    held.drive(np.array([7.0]))
    seized.advance(0.1)
    held.advance(0.1)
    assert np.array_equal(seized.pressures, held.pressures)


def test_a_kink_narrows_what_a_valve_lets_through() -> None:
    rises = []
    for share in (1.0, 0.5, 0.0):
        plant = late(0)
        plant.seize(0, 1.0)
        plant.kink(0, share)
        plant.advance(0.01)
        rises.append(plant.pressures[0, 0] - FULL[0])
    assert rises[0] > 1e4
    assert rises[1] == pytest.approx(0.5 * rises[0], rel=0.1)
    assert rises[2] == pytest.approx(0.0, abs=1.0)


def test_failures_leave_supply_and_payload_alone() -> None:
    plant = SteppedPlant(ARM, payload="2 kg")
    plant.supply = 3e5
    plant.kink(1, 0.5)
    assert (plant.supply, plant.payload) == (3e5, 2.0)


def test_a_machine_that_diverges_says_so() -> None:
    plant = SteppedPlant(changed(ARM, "joint.small.stops.stop_stiffness", 1e9))
    plant.load[:] = 0.0, 100.0
    with pytest.raises(DivergedError, match=r"diverged at t = .* in joint 'small'; a shorter step"):
        plant.advance(5.0)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"pressures": (0.0, 0.0)}, "pressures: 0 Pa is out of range; give absolute pressures"),
        ({"start": "70 deg"}, "start: 70 deg is outside the working stroke"),
        ({"step": "1 s"}, "step: 1 s is out of range"),
        ({"payload": "1 bar"}, "payload"),
    ],
)
def test_wrong_options(options: dict[str, str], expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        SteppedPlant(SMALL, **options)  # type: ignore[arg-type]


def test_a_rig_without_valves_is_refused() -> None:
    with pytest.raises(InputError, match="has no valve or sensors"):
        SteppedPlant(load("rig-kevlar"))


@pytest.mark.parametrize("wrong", [None, "x", 1j, True, b"1", [1.0, 2.0, 3.0], float("nan"), float("inf"), {"x": 1}])
def test_what_moves_a_plant_is_checked(wrong: Any) -> None:
    plant = SteppedPlant("paper-arm-fast", noise=False)
    for move in (
        plant.drive,
        plant.advance,
        lambda value: plant.grip(0, value),
        lambda value: plant.grip(value, 1.0),
        lambda value: setattr(plant, "payload", value),
    ):
        with pytest.raises(InputError) as caught:
            move(wrong)
        assert "\n" not in str(caught.value)
    plant.advance(0.1)
    assert np.isfinite(plant.angles).all()
    assert plant.payload == load("paper-arm-fast").arm.payload


def test_what_no_plant_can_do_is_refused() -> None:
    plant = SteppedPlant(ARM, noise=False)
    with pytest.raises(InputError, match="until: 1e\\+09 s is too far away"):
        plant.advance(1e9)
    with pytest.raises(InputError, match="joint: 2 is out of range; give 0 to 1"):
        plant.grip(2, 1.0)
    with pytest.raises(InputError, match="payload: -1 kg is out of range"):
        plant.payload = -1.0
    plant.payload = "2 kg"
    assert plant.payload == 2.0
