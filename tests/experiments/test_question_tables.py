"""What the questions take from tables, over tables that are made up."""

from types import SimpleNamespace

import numpy as np
import pandas
import pytest

from layflat.experiments.questions import (
    assumptions,
    brake_and_inertia,
    dither,
    join_words,
    losses_and_brake,
    median_grid,
    move_names,
    rest_errors,
    supply_pressure,
    total_hysteresis,
)
from layflat.machine import load


def test_moves_are_found_by_their_settling() -> None:
    frame = pandas.DataFrame(columns=["settling.small.0", "ripple.small.0", "settling.large.1", "air_used"])
    assert move_names(frame) == ["small.0", "large.1"]


def test_rest_is_error_and_half_the_ripple() -> None:
    values = {"steady_error.a.0": np.radians([-1.0, 2.0]), "ripple.a.0": np.radians([0.5, 1.0])}
    assert rest_errors(pandas.DataFrame(values), ["a.0"])[:, 0] == pytest.approx([1.25, 2.5])


@pytest.mark.parametrize(("words", "text"), [(["a"], "a"), (["a", "b"], "a and b"), (["a", "b", "c"], "a, b and c")])
def test_words_in_a_sentence(words: list[str], text: str) -> None:
    assert join_words(words) == text


def test_a_grid_has_its_axes_in_order() -> None:
    frame = pandas.DataFrame({"x": [2.0, 1.0, 2.0, 1.0], "y": [5.0, 5.0, 3.0, 3.0], "z": [1.0, 2.0, 3.0, 4.0]})
    across, upward, values = median_grid(frame, "x", "y", "z")
    assert (across.tolist(), upward.tolist()) == ([1.0, 2.0], [3.0, 5.0])
    assert values.tolist() == [[4.0, 3.0], [2.0, 1.0]]


def test_hysteresis_grows_with_the_brake() -> None:
    machine = load("paper-small-joint")
    without, half, full = (total_hysteresis(machine, level) for level in (0.0, 0.5, 1.0))
    assert without == pytest.approx(7.3, abs=0.1)
    assert full == pytest.approx(24.9, abs=0.1)
    assert half == pytest.approx((without + full) / 2)


def test_a_single_late_field_does_not_end_what_is_carried() -> None:
    ratios = np.geomspace(0.01, 0.1, 7)
    times = np.ones((7, 5))
    times[3, 2] = np.inf
    assert brake_and_inertia._smoothed_limits(ratios, times, 1.5).tolist() == [ratios[-1]] * 5
    times[3] = np.inf
    times[4] = np.inf
    assert brake_and_inertia._smoothed_limits(ratios, times, 1.5).max() < ratios[4]


@pytest.mark.parametrize(
    ("errors", "enough"),
    [
        ([0.5, 0.1, 0.1, 0.1], 0.1),
        ([0.1, 0.1, 0.1, 0.1], 0.0),
        ([0.5, 0.1, 0.5, 0.1], 0.3),
        ([0.1, 0.1, 0.5, 0.5], 0.3),
    ],
)
def test_enough_dither_is_from_where_on_the_error_stays_near_the_least(errors: list[float], enough: float) -> None:
    assert dither._sufficient_amplitude(np.array([0.0, 0.1, 0.2, 0.3]), np.array(errors)) == enough


def test_amplitudes_are_compared_at_one_friction_and_frequency() -> None:
    runs = pandas.DataFrame(
        {
            dither.FRICTION: [0.1, 0.1, 0.1, 0.2, 0.1],
            dither.AMPLITUDE: [0.0, 0.1, 0.1, 0.1, 0.1],
            dither.FREQUENCY: [50.0, 45.0, 55.0, 50.0, 150.0],
            "error": [5.0, 1.0, 3.0, 9.0, 9.0],
        }
    )
    amplitudes, errors = dither._mean_by_amplitude(runs, "error", 0.1)
    assert (amplitudes.tolist(), errors.tolist()) == ([0.0, 0.1], [5.0, 2.0])


def test_shares_of_a_brake_in_words() -> None:
    assert losses_and_brake._describe_division(0.0) == "all of it in the hose"
    assert losses_and_brake._describe_division(0.4) == "40 % of it in the brake"
    assert losses_and_brake._describe_ratio(3.0, 2.0) == "1.5 times"
    assert losses_and_brake._describe_ratio(3.0, 0.0) == "incomparably"
    assert losses_and_brake._describe_ripple(0.01) == "nothing is left of the motion"


def supply_table() -> pandas.DataFrame:
    rows = []
    for bar in (2.0, 4.0):
        for variant in (supply_pressure.DITHER_VARIANT, supply_pressure.NO_DITHER_VARIANT):
            for scenario in ("push, air shut in", "push 4 N m", "step", "hold"):
                air = {"hold": 0.75 if variant == supply_pressure.DITHER_VARIANT else 0.15, "step": 1.0}.get(
                    scenario, 0.0
                )
                rows.append((variant, scenario, bar * 1e5, np.radians(4.0 / bar), np.radians(2.0), 3.0 / bar, air))
    columns = ["variant", "scenario", supply_pressure.PRESSURE_COLUMN, "steady_error.small.0", "ripple.small.0"]
    return pandas.DataFrame(rows, columns=[*columns, "settling.small.0", "air_used"])


def test_supply_results_are_loads_over_angles_and_air_by_the_minute() -> None:
    found = supply_pressure.results_by_pressure(supply_table())
    assert found["pressure"].tolist() == [2.0, 4.0]
    assert found["air stiffness"] == pytest.approx([1.0, 2.0])
    assert found["joint stiffness"] == pytest.approx([2.0, 2.0])
    assert found["settling"] == pytest.approx([1.5, 0.75])
    assert found["air at rest"] == pytest.approx([10.0, 10.0])
    assert found["leakage"] == pytest.approx([2.0, 2.0])
    assert found["air of a step"] == pytest.approx([0.25, 0.25])


def test_the_finding_of_a_supply_is_that_of_its_table() -> None:
    study = SimpleNamespace(machine=load("paper-small-joint"))
    said = supply_pressure.finding(study, supply_table())  # type: ignore[arg-type]
    assert "From 2 to 4 bar the air alone gets 2.0 times as stiff (1.00 to 2.00 N m per deg)" in said
    assert "holds against 4 N m stays, from 2.0 to 2.0 N m per deg" in said
    assert "The joint settles within 1.5 s at every pressure" in said
    assert "takes 10 normal litres a minute, 80 % of it because of dither, and a step 0.25 more" in said


def test_assumed_results_take_the_worst_move_and_clip_what_never_settles() -> None:
    frame = pandas.DataFrame(
        {
            "scenario": ["braked", "without brake", "braked"],
            "settling.small.0": [0.5, 9.0, np.inf],
            "settling.large.0": [0.7, 9.0, np.nan],
            "ripple.small.0": [0.1, 9.0, np.nan],
            "ripple.large.0": [0.2, 9.0, 0.1],
            "tip_error.0": [1e-3, 9.0, 5.0],
        }
    )
    found = assumptions.worst_results(frame)
    assert found["settling"].tolist() == [0.7, assumptions.MOVE_DURATION]
    assert found["ripple"].tolist() == [0.2, np.pi]
    assert found["tip error"].tolist() == [1e-3, 1.0]


def test_paths_as_people_read_them() -> None:
    assert assumptions.readable_path("joint.large.hose.dead_volume") == "hose dead volume"
    assert assumptions.readable_path("valve.natural_frequency") == "valve natural frequency"
