"""Claims and their rules: made-up runs give made-up verdicts."""

from collections.abc import Callable
from math import inf, nan, radians
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray

from layflat.errors import DivergedError, InputError, MachineError
from layflat.experiments.axis_one import (
    DURATION,
    SETTLING_LIMITS,
    STEP_TIME,
    AxisOneExperiment,
    InertiaSweep,
    is_sustained,
)
from layflat.experiments.bench import load_bench
from layflat.experiments.claim import Claim, ClaimQuantity, ClaimRule, Evaluation, Experiment
from layflat.experiments.controller import ControllerExperiment
from layflat.experiments.dither import DitherExperiment, ValveSweep, amplitude_at, averaged_angle, frequency_response
from layflat.experiments.open_loop import OpenLoopExperiment
from layflat.experiments.reproduction import first_disagreement
from layflat.experiments.statics import MEASURED_TORQUES, PRINTED_MEAN_TORQUE, StaticsExperiment
from layflat.experiments.two_axis import APPROACH_COUNT, END_TIME, TwoAxisExperiment, settling_to_final
from layflat.machine import load, parameters
from layflat.sim.metrics import disturbance

TIME = np.arange(0.0, STEP_TIME + DURATION + 1e-9, 0.005)


def evaluated(rule: ClaimRule, **runs: Any) -> tuple[dict[str, float], bool]:
    """The quantities by name, and the verdict, of a claim over made-up runs."""
    quantities, agrees = rule.evaluate(SimpleNamespace(**runs))
    return {one.name: one.value for one in quantities}, bool(agrees)


def one_joint(angle: np.ndarray, time: np.ndarray = TIME) -> xarray.Dataset:
    """A run of the small joint (deg) that is asked for 20 deg."""
    values = {"angle": radians(1.0) * angle[:, None], "demand": np.full((len(time), 1), radians(20.0))}
    data = {name: (("time", "joint"), value) for name, value in values.items()}
    return xarray.Dataset(data, {"time": time, "joint": ["small"]})


def arriving(after: float, time: np.ndarray = TIME) -> xarray.Dataset:
    """A run that jumps to its demand so many seconds after the step."""
    return one_joint(np.where(time >= STEP_TIME + after - 1e-9, 20.0, -20.0), time)


def claim(*texts: Any) -> Callable[[Callable[[Any], Evaluation]], ClaimRule]:
    return lambda evaluate: ClaimRule(Claim(*texts), evaluate)


class Made(Experiment):
    """Rules that do what a test asks for."""

    @claim("one", "1", "says", "criterion")
    def one(self) -> Evaluation:
        return [ClaimQuantity("a", 2.0, "m", "3")], True

    @claim("two", "2", "says", "criterion")
    def two(self) -> Evaluation:
        return [ClaimQuantity("a", inf, "s"), ClaimQuantity("b", nan)], np.bool_(False)  # type: ignore[return-value]

    @claim("lacking", "3", "says", "criterion")
    def lacking(self) -> Evaluation:
        raise MachineError("has no arm", where="mine.toml", right="add one")


MADE = {rule.claim.id: rule for rule in Made.rules()}


def test_rules_are_found_and_judged_in_order() -> None:
    assert list(MADE) == ["one", "two", "lacking"]
    made = Made(None)  # type: ignore[arg-type]
    first, second, third = (rule.evaluate_claim(made) for rule in MADE.values())
    assert (first.agrees, second.agrees, third.agrees) == (True, False, None)
    assert (first.verdict, second.verdict, third.verdict) == ("agrees", "does not agree", "not evaluated")
    assert third.reason == "not applicable: mine.toml: has no arm"
    assert third.quantities == ()


def test_what_comes_after_a_claim_that_does_not_agree_is_not_evaluated() -> None:
    class Applies(Made):
        @claim("three", "3", "says", "criterion")
        def three(self) -> Evaluation:
            raise AssertionError

        one, lacking = Made.one, Made.lacking

    class Fits(Made):
        one, lacking = Made.one, Made.lacking

    assert first_disagreement(load_bench(), [Fits]) == ""
    assert first_disagreement(load_bench(), [Fits, Made, Applies]) == "two"


def test_records_keep_numbers_units_and_what_the_paper_gives() -> None:
    first, second, third = (rule.evaluate_claim(Made(None)).record() for rule in MADE.values())  # type: ignore[arg-type]
    assert (first["simulated"], first["unit"], first["paper_value"], first["agrees"]) == (2.0, "m", "3", True)
    assert second["simulated"] == {"a": None, "b": None}
    assert second["unit"] == {"a": "s", "b": "1"}
    assert second["agrees"] is False
    assert (third["simulated"], third["agrees"]) == (None, None)
    assert third["reason"].startswith("not applicable")
    assert "reason" not in first


@pytest.mark.parametrize(
    ("error", "agrees", "reason"),
    [
        (MachineError("has no arm", where="mine"), None, "not applicable: mine: has no arm"),
        (InputError("outside the stroke", where="demand"), False, "can't be simulated: demand: outside the stroke"),
    ],
)
def test_only_what_a_machine_lacks_makes_a_claim_not_applicable(
    error: Exception, agrees: bool | None, reason: str
) -> None:
    def evaluate(_: Experiment) -> Evaluation:
        raise error

    found = ClaimRule(Claim("x", "", "", ""), evaluate).evaluate_claim(Made(None))  # type: ignore[arg-type]
    assert (found.agrees, found.reason) == (agrees, reason)


def test_a_run_that_diverges_unseen_ends_the_work() -> None:
    def evaluate(_: Experiment) -> Evaluation:
        raise DivergedError(1.0, "small")

    with pytest.raises(DivergedError):
        ClaimRule(Claim("x", "", "", ""), evaluate).evaluate_claim(Made(None))  # type: ignore[arg-type]


def swinging(until: float, size: float = 3.0, left: float = 0.1, period: float = 0.5) -> xarray.Dataset:
    """A run that reaches its demand in half a second, and swings by `size` (deg) until some time, then by `left`."""
    since = TIME - STEP_TIME
    swing = np.where(since < until, size, left) * np.cos(2 * np.pi * since / period)
    return one_joint(np.where(since < 0.5, -20.0, 20.0 + swing))


@pytest.mark.parametrize(
    ("unbraked", "earlier", "agrees"),
    [
        (swinging(5.0), 1.0, True),
        (swinging(5.0), 3.0, False),
        (swinging(5.0), inf, False),
        (swinging(1.5), 0.5, False),
        (swinging(8.6), 1.0, False),
        (swinging(5.0, left=0.6), 1.0, False),
        (swinging(5.0, size=21.0), 1.0, False),
    ],
    ids=["agrees", "earlier is slow", "earlier never settles", "too soon", "too late", "swings on", "overshoots"],
)
def test_the_unbraked_joint_takes_long_and_the_earlier_does_not(
    unbraked: xarray.Dataset, earlier: float, agrees: bool
) -> None:
    found, said = evaluated(AxisOneExperiment.unbraked_joint, unbraked=unbraked, earlier=arriving(earlier))
    assert found["earlier actuator settles in"] == pytest.approx(earlier)
    assert said is agrees


def test_what_the_unbraked_joint_does_is_measured_against_its_own_end() -> None:
    found, _ = evaluated(AxisOneExperiment.unbraked_joint, unbraked=swinging(5.0), earlier=arriving(1.0))
    assert found["new joint arrives in"] == pytest.approx(5.0, abs=0.25)
    assert found["oscillation left"] == pytest.approx(0.2, rel=0.01)
    assert found["overshoot"] == pytest.approx(3.0, rel=0.01)


def test_an_oscillation_that_grows_does_not_agree() -> None:
    since = TIME - STEP_TIME
    growing = 0.02 * np.exp(since / 4.0) * np.cos(12.0 * since)
    late = one_joint(np.where(since < 3.0, -20.0, 20.0 + growing))
    assert (
        evaluated(AxisOneExperiment.unbraked_joint, unbraked=late, earlier=arriving(1.0))[0]["oscillation left"] < 1.0
    )
    assert not evaluated(AxisOneExperiment.unbraked_joint, unbraked=late, earlier=arriving(1.0))[1]


def test_an_unbraked_joint_that_diverges_does_not_agree() -> None:
    short = arriving(9.0, TIME[TIME < 1.2])
    found, said = evaluated(AxisOneExperiment.unbraked_joint, unbraked=short, earlier=arriving(1.0))
    assert found == {"diverged after": pytest.approx(1.2 - STEP_TIME, abs=0.006)}
    assert said is False


def carrying(times: tuple[float, ...], stable: int) -> InertiaSweep:
    """A joint that settles in these times with more and more inertia, and swings on from the `stable`th on."""
    ratios = (0.01, 0.02, 0.04, 0.08)
    return InertiaSweep(dict(zip(ratios, times, strict=True)), {ratio: i >= stable for i, ratio in enumerate(ratios)})


def test_the_braked_joint_is_compared_by_its_limits() -> None:
    braked, earlier = carrying((0.5, 1.0, 1.4, inf), 3), carrying((0.5, 1.0, inf, inf), 2)

    def compared(run: xarray.Dataset, new: InertiaSweep, old: InertiaSweep) -> tuple[dict[str, float], bool]:
        return evaluated(AxisOneExperiment.braked_joint, braked=run, carried_braked=new, carried_earlier=old)

    found, said = compared(arriving(0.8), braked, earlier)
    assert said
    assert found["settling"] == pytest.approx(0.8)
    assert (found["limit with brake"], found["limit of earlier"]) == (0.04, 0.02)
    assert {value for name, value in found.items() if name.startswith("ratio")} == {2.0}
    assert len(found) == 3 + len(SETTLING_LIMITS) + 1
    assert not compared(arriving(0.8), earlier, earlier)[1]
    # One window, or the limit of oscillation, that is off is enough.
    assert not compared(arriving(0.8), braked, carrying((0.5, 1.0, 5.0, inf), 2))[1]
    assert not compared(arriving(0.8), braked, carrying((0.5, 1.0, inf, inf), 3))[1]
    assert not compared(swinging(20.0, size=0.4), braked, earlier)[1]


def test_an_oscillation_is_sustained_unless_it_is_small_or_fades() -> None:
    time = np.arange(0.0, 12.0, 0.005)
    swing = np.sin(8.0 * time)
    assert is_sustained(time, np.radians(1.0) * swing)
    assert not is_sustained(time, np.radians(0.2) * swing)
    assert not is_sustained(time, np.radians(30.0) * np.exp(-0.3 * time) * swing)


def two_joints(pushed: float, off: float = 0.0) -> xarray.Dataset:
    """The arm's two steps: the large joint's pushes the small one by so many degrees; the last error is `off` (deg)."""
    time = np.arange(0.0, END_TIME + 1e-9, 0.005)
    large, small = np.where(time < 0.5, -20.0, 20.0), np.where(time < 4.0, -20.0, 20.0)
    angle, demand = np.radians([[large + off], [small + off]]), np.radians([[large], [small]])
    angle[1, 0] += np.radians(pushed) * ((time > 0.6) & (time < 0.8))
    angle[0, 0] += np.radians(0.1) * ((time > 4.1) & (time < 4.2))
    data = {name: (("time", "joint"), values[:, 0].T) for name, values in (("angle", angle), ("demand", demand))}
    return xarray.Dataset(data, {"time": time, "joint": ["large", "small"]})


@pytest.mark.parametrize(
    ("pushed", "off", "agrees"), [(7.0, 0.0, True), (0.2, 0.0, False), (7.0, 0.4, False), (7.0, 0.2, True)]
)
def test_coupling_compares_peaks_and_what_stays(pushed: float, off: float, agrees: bool) -> None:
    found, said = evaluated(TwoAxisExperiment.coupling, steps=two_joints(pushed, off))
    assert found["small disturbed"] == pytest.approx(pushed)
    assert found["large disturbed"] == pytest.approx(0.1)
    assert found["worst error at rest"] == pytest.approx(off, abs=1e-9)
    assert said is agrees


def test_an_arm_that_diverges_has_not_settled() -> None:
    part = two_joints(7.0).sel(time=slice(None, 3.0))
    found, said = evaluated(TwoAxisExperiment.settling, steps=part)
    assert found == {"diverged after": 3.0}
    assert said is False


def test_a_joint_settles_on_its_own_final_value() -> None:
    run = two_joints(7.0, off=0.25)
    assert settling_to_final(run, "large", 0.5, 3.9) == 0.0
    assert settling_to_final(run, "small", 0.5, 3.9) == pytest.approx(0.3, abs=0.006)
    assert disturbance(run, "small", 1.0, 3.9) == 0.0


@pytest.mark.parametrize(("spread", "reach", "agrees"), [(0.05, 1e-3, True), (0.15, 1e-3, False), (0.05, 3e-3, False)])
def test_repeatability_is_half_the_spread(spread: float, reach: float, agrees: bool) -> None:
    signs = np.where(np.arange(APPROACH_COUNT) % 2, 1.0, -1.0)
    rest = np.radians(spread) * np.stack([signs, 0.5 * signs], axis=1)
    found, said = evaluated(
        TwoAxisExperiment.repeatability, rest_angles=rest, tip=reach * np.stack([signs, 0.0 * signs], axis=1)
    )
    assert found == pytest.approx({"large": spread, "small": 0.5 * spread, "tip": 1e3 * reach})
    assert said is agrees


def test_an_arm_that_does_not_come_back_repeats_nothing() -> None:
    found, said = evaluated(
        TwoAxisExperiment.repeatability,
        rest_angles=np.zeros((APPROACH_COUNT - 1, 2)),
        tip=np.zeros((APPROACH_COUNT - 1, 2)),
    )
    assert set(found.values()) == {inf}
    assert said is False


def curve(hysteresis: float, height: float = 1.0) -> SimpleNamespace:
    return SimpleNamespace(hysteresis=hysteresis, height=height, maximum_torque=height / hysteresis)


@pytest.mark.parametrize(
    ("earlier", "now", "braked", "agrees"),
    [(0.25, 0.07, 0.25, True), (0.29, 0.07, 0.25, False), (0.25, 0.1, 0.25, False), (0.25, 0.07, 0.2, False)],
)
def test_hysteresis_is_told_in_percent(earlier: float, now: float, braked: float, agrees: bool) -> None:
    runs = {"earlier": curve(earlier), "unbraked": curve(now), "braked": curve(braked)}
    found, said = evaluated(OpenLoopExperiment.hysteresis, **runs)
    assert list(found.values()) == pytest.approx([100 * earlier, 100 * now, 100 * braked])
    assert said is agrees


def test_a_brake_that_adds_nothing_keeps_nothing() -> None:
    same = curve(0.2)
    shapes = {"unbraked": same, "braked": same, "earlier": same}
    bench = SimpleNamespace(brake=1.0, earlier=None, curve=lambda *_, **__: same)
    found, said = evaluated(OpenLoopExperiment.character, **shapes, bench=bench)
    assert found == {"height kept with brake": 0.0, "height kept by the earlier": 100.0}
    assert said is False


@pytest.mark.parametrize(
    ("name", "top", "agrees"), [("large", 88.0, True), ("large", 79.0, False), ("small", 25.0, True)]
)
def test_torque_is_compared_with_what_was_measured(name: str, top: float, agrees: bool) -> None:
    bench = SimpleNamespace(brake=1.0, curve=lambda _, **__: SimpleNamespace(maximum_torque=top))
    made = SimpleNamespace(bench=bench)
    made._torque = lambda *words: StaticsExperiment._torque(made, *words)  # type: ignore[arg-type]
    rule: ClaimRule = getattr(StaticsExperiment, f"{name}_joint_torque")
    ((quantity,), said) = rule.evaluate(made)
    assert (quantity.value, quantity.paper, said) == (top, f"{MEASURED_TORQUES[name]:g}", agrees)


def test_the_mean_torque_has_to_round_to_the_printed_one() -> None:
    arm = load("paper-arm")
    bench = SimpleNamespace(arm=arm, joint=lambda name: arm.joint[name])
    for crude, agrees in ((PRINTED_MEAN_TORQUE + 4e-6, True), (PRINTED_MEAN_TORQUE + 2e-5, False)):
        found, said = evaluated(StaticsExperiment.mean_torque, bench=bench, table=SimpleNamespace(mean_torque=crude))
        assert found["as the table"] == crude
        assert said is agrees


def sweep(width: float, gain: float) -> ValveSweep:
    command = np.linspace(-0.2, 0.2, 81)
    return ValveSweep(command, gain * command - width / 2, gain * command + width / 2)


def test_the_need_of_dither_is_read_off_the_sweeps() -> None:
    assert sweep(0.1, 0.9).hysteresis == pytest.approx(0.1)
    assert sweep(0.1, 0.9).gain == pytest.approx(0.9)
    good = {"without": sweep(0.1, 0.9), "normal": sweep(0.01, 0.9), "fast": sweep(0.0, 1.0)}
    assert evaluated(DitherExperiment.need, sweeps=good)[1]
    assert not evaluated(DitherExperiment.need, sweeps={**good, "normal": sweep(0.05, 0.9)})[1]
    assert not evaluated(DitherExperiment.need, sweeps={**good, "fast": sweep(0.0, 0.9)})[1]


def test_an_amplitude_is_found_in_noise_free_ripple() -> None:
    time = np.arange(0.0, 1.0, 0.0005)
    signal = 3.0 + 0.25 * np.sin(2 * np.pi * 50.0 * time + 1.0) + 0.5 * np.sin(2 * np.pi * 100.0 * time)
    assert amplitude_at(time, signal, 50.0) == pytest.approx(0.25)
    assert amplitude_at(time, signal, 70.0) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("frequency", [1.0, 17.0, 50.0])
def test_the_response_of_the_average_is_that_of_the_controller(frequency: float) -> None:
    arm = load("paper-arm")
    time: Any = arm.cycle * np.arange(404)
    signal: Any = np.sin(2 * np.pi * frequency * time)
    used = averaged_angle(parameters.control(arm).joints[-1], arm.cycle, signal)[4:]
    (gain,) = frequency_response(np.array([frequency]), arm.cycle)
    assert amplitude_at(time[4:], used, frequency) == pytest.approx(gain, abs=1e-9)


def test_the_integral_may_learn_at_rest_only() -> None:
    machine = load("paper-small-joint")

    def run(moved: float = 0.0, **changes: Any) -> xarray.Dataset:
        learns = 0.25 * 0.96 if "duration" in changes else moved
        values = np.array([[0.0], [0.0], [learns]])
        return xarray.Dataset({"long_term": (("time", "joint"), values)}, {"time": [0.0, 5.0, 9.0], "joint": ["small"]})

    bench = SimpleNamespace(axis_one=machine)
    found, said = evaluated(ControllerExperiment.rules_of_the_integral, bench=bench, volts=0.25, run=run)
    assert found == pytest.approx({"drift taken over": 96.0, "air off": 0.0, "in motion": 0.0, "offset load": 0.0})
    assert said
    moving = lambda **changes: run(0.01 if "demand" in changes else 0.0, **changes)  # noqa: E731
    found, said = evaluated(ControllerExperiment.rules_of_the_integral, bench=bench, volts=0.25, run=moving)
    assert found["in motion"] == pytest.approx(0.01)
    assert not said


@pytest.mark.parametrize(("seconds", "agrees"), [(1e-6, True), (2e-5, False)])
def test_a_cycle_has_a_limit(seconds: float, agrees: bool) -> None:
    found, said = evaluated(ControllerExperiment.control_cycle, all_axes=seconds)
    assert found == pytest.approx({"time of a cycle": 1e6 * seconds})
    assert said is agrees
