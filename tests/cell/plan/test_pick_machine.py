from dataclasses import replace
from math import dist

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.cell.plan.pick import CellReadings, PickCommand, PickOutcome, PickPhase, PickState, Relocation
from layflat.cell.plan.pick_machine import NEXT_PHASES, SUCTION_PHASES, PickEvent, begin_pick, step_pick
from tests.cell.plan.scripted_plant import CARRYING, CYCLE, LONGEST, PASSING, RULES, TASK, Plant, phases, run

ELSEWHERE = replace(TASK, over_fruit=(0.15, 0.1))


def test_a_pick_goes_its_way_and_lays_the_fruit_into_its_place() -> None:
    plant = Plant()
    state, trace = run(plant)
    assert state.outcome is PickOutcome.PLACED
    way = [
        PickPhase.APPROACH,
        PickPhase.LOWER,
        PickPhase.SEAL,
        PickPhase.LIFT,
        PickPhase.CARRY,
        PickPhase.PLACE,
        PickPhase.RELEASE,
        PickPhase.RAISE,
    ]
    assert phases(trace) == [*way, PickPhase.DONE]
    assert len(plant.laid) == 1
    assert plant.laid[0] == pytest.approx(TASK.over_place, abs=1e-9)
    assert state.tried == 1
    assert state.trouble == ""


def test_a_missed_fruit_is_tried_again_where_a_new_picture_shows_it() -> None:
    plant = Plant(fruit={ELSEWHERE.over_fruit: 50e3}, relocations=[Relocation(ELSEWHERE)])
    state, trace = run(plant)
    assert state.outcome is PickOutcome.PLACED
    assert state.tried == 2
    seen_from = [s for s, command in trace if command.image]
    assert seen_from
    assert all(s.target == RULES.clear for s in seen_from)


def test_after_enough_tries_it_is_missed() -> None:
    state, trace = run(Plant(fruit={}, relocations=[Relocation(TASK)] * 9))
    assert state.outcome is PickOutcome.MISSED
    assert state.trouble == "no vacuum built up"
    assert phases(trace).count(PickPhase.LOWER) == RULES.tries


def test_a_fruit_that_a_new_picture_no_longer_shows_is_gone() -> None:
    assert run(Plant(fruit={}, relocations=[Relocation(None)]))[0].outcome is PickOutcome.GONE


def test_without_a_picture_it_is_stuck() -> None:
    state, _ = run(Plant(fruit={}))
    assert (state.outcome, state.trouble) == (PickOutcome.STUCK, "no image came")


@pytest.mark.parametrize("phase", [PickPhase.CARRY, PickPhase.PLACE])
def test_a_fruit_that_falls_on_its_way_is_lost(phase: PickPhase) -> None:
    plant = Plant(drops_at=phase)
    state, _ = run(plant)
    assert state.outcome is PickOutcome.LOST
    assert phase.value in state.trouble
    assert plant.laid == []


def test_a_fruit_that_slips_while_it_is_lifted_is_tried_again() -> None:
    state, trace = run(Plant(drops_at=PickPhase.LIFT, relocations=[Relocation(TASK)] * 9))
    assert state.outcome is PickOutcome.MISSED
    assert PickPhase.CARRY not in phases(trace)
    assert state.trouble == "it slipped off the cup"


def test_two_fruits_in_the_cup_leak_and_are_let_go_where_they_were() -> None:
    plant = Plant(fruit={TASK.over_fruit: 20e3}, relocations=[Relocation(None)])
    state, trace = run(plant)
    assert state.outcome is PickOutcome.GONE
    assert PickPhase.LIFT not in phases(trace)
    assert plant.laid[0] == pytest.approx(TASK.over_fruit, abs=1e-3)
    assert "two fruits" in state.trouble


def test_what_is_too_heavy_is_put_back() -> None:
    plant = Plant(lift_speed=0.1, relocations=[Relocation(None)])
    state, trace = run(plant)
    assert state.outcome is PickOutcome.GONE
    assert PickPhase.PUT_BACK in phases(trace)
    assert PickPhase.CARRY not in phases(trace)
    assert plant.laid[0] == pytest.approx(TASK.over_fruit, abs=1e-3)


@pytest.mark.parametrize("top", [0.067, 0.0615, 0.0585, 0.0545])
def test_a_fruit_that_is_higher_or_flatter_than_it_seemed_is_let_go_as_much_higher(top: float) -> None:
    state, trace = run(Plant(top=top))
    assert (state.outcome, state.tried) == (PickOutcome.PLACED, 1)
    assert state.task.place_height == pytest.approx(TASK.place_height + top - TASK.fruit_height, abs=1e-9)
    assert next(command.height for s, command in trace if s.phase is PickPhase.PLACE) == state.task.place_height


def test_a_vacuum_that_does_not_go_ends_the_pick_where_the_arm_is() -> None:
    plant = Plant(leaves=False)
    state, trace = run(plant)
    assert (state.outcome, state.trouble) == (PickOutcome.STUCK, "the vacuum does not decay")
    assert trace[-1][1].target == TASK.over_place


def test_every_phase_is_entered_and_leads_to_the_end() -> None:
    assert set(NEXT_PHASES) == set(PickPhase)
    entered = {PickPhase.APPROACH, PickPhase.FOLLOW} | {
        phase for after in NEXT_PHASES.values() for phase in after.values()
    }
    assert entered == set(PickPhase)
    ends = {PickPhase.DONE}
    for _ in PickPhase:
        ends |= {phase for phase, after in NEXT_PHASES.items() if ends & set(after.values())}
    assert ends == set(PickPhase)
    assert all(PickEvent.STUCK not in after for after in NEXT_PHASES.values())  # it ends a pick in any phase


def test_suction_is_switched_off_only_where_a_fruit_is_released_or_lost() -> None:
    for phase, after in NEXT_PHASES.items():
        for event, following in after.items():
            if phase in SUCTION_PHASES and following not in SUCTION_PHASES | {PickPhase.DONE}:
                assert following in {PickPhase.RELEASE, PickPhase.RELEASE_BACK} or event is PickEvent.DROPPED


def _measured(time: float, angles: tuple[float, ...], **others: object) -> CellReadings:
    still = CellReadings(time, angles, (0.0, 0.0), 0.0, CARRYING)
    return replace(still, **others)  # type: ignore[arg-type]


def test_it_waits_until_the_arm_is_near_and_still() -> None:
    state = begin_pick(TASK, _measured(0.0, (0.0, 0.0)))
    over = TASK.over_fruit
    for k in range(40):  # in passing
        state, command = step_pick(RULES, state, _measured(CYCLE * k, over, velocities=(0.5, 0.0)))
        assert state.phase is PickPhase.APPROACH
    for k in range(40, 60):  # still, but beside
        state, command = step_pick(RULES, state, _measured(CYCLE * k, (over[0] + 0.01, over[1])))
        assert state.phase is PickPhase.APPROACH
    state, command = step_pick(RULES, state, _measured(0.3, over))
    assert command.height == PASSING
    state, command = step_pick(RULES, state, _measured(0.3 + RULES.dwell, over))
    assert command.height == TASK.fruit_height


def test_an_arm_that_is_pushed_while_the_cup_is_down_is_raised_at_once() -> None:
    for phase in (PickPhase.LOWER, PickPhase.SEAL, PickPhase.PLACE):
        state = PickState(TASK, phase, 0.0, TASK.over_fruit, suction=True)
        vacuum = 50e3
        pushed = (state.phase_angles[0] + 0.02, state.phase_angles[1])
        after, command = step_pick(RULES, state, _measured(0.01, pushed, height=0.07, vacuum=vacuum))
        assert command.height == CARRYING
        assert command.suction
        assert after.shaken == 1


def test_an_arm_that_is_pushed_again_and_again_ends_with_the_fruit_held() -> None:
    state, lowered, now = PickState(TASK, PickPhase.CARRY, 0.0, TASK.over_place, suction=True), 0, 0.0
    over = TASK.over_place
    while state.phase is not PickPhase.DONE:
        now += 0.05
        pushed = state.phase is PickPhase.PLACE
        lowered += pushed
        at = (over[0] + 0.02 * pushed, over[1])
        state, command = step_pick(RULES, state, _measured(now, at, height=0.07 if pushed else CARRYING, vacuum=50e3))
        assert now < LONGEST
    assert lowered == RULES.tries
    assert state.outcome is PickOutcome.STUCK
    assert command.suction
    assert command.height == CARRYING


# Whatever sensors say.

NEAR = st.sampled_from([TASK.over_fruit, TASK.over_place, RULES.clear, ELSEWHERE.over_fruit])
OFFSETS = st.sampled_from([0.0, 0.0, 0.0, 0.0, 0.001, 0.006, 0.05])
READINGS = st.builds(
    lambda dt, at, off, v, vacuum, height, lift, relocation: (
        dt,
        (at[0] + off, at[1]),
        (v, 0.0),
        vacuum,
        height,
        lift,
        relocation,
    ),
    st.sampled_from([0.005, 0.02, 0.05, 0.3, 1.0]),
    NEAR,
    OFFSETS,
    st.sampled_from([0.0, 0.0, 0.0, 0.05, 0.2, 1.0]),
    st.sampled_from([0.0, 9e3, 15e3, 31e3, 60e3]),
    st.sampled_from([0.04, TASK.place_height, TASK.fruit_height, 0.07, PASSING, PASSING, CARRYING, CARRYING, 0.2]),
    st.sampled_from([0.0, -0.3, 0.3]),
    st.sampled_from([None, None, Relocation(ELSEWHERE), Relocation(TASK), Relocation(None)]),
)


Reading = tuple[float, tuple[float, ...], tuple[float, ...], float, float, float, Relocation | None]


def _towards(state: PickState, reading: Reading) -> Reading:
    """The same with the arm about where this phase wants it, so that picks get far."""
    dt, angles, *others = reading
    wanted = RULES.clear if state.phase in {PickPhase.CLEAR, PickPhase.AWAIT_IMAGE} else state.phase_angles
    off = min((angles[0] - at[0] for at in (TASK.over_fruit, TASK.over_place, RULES.clear)), key=abs)
    return dt, (wanted[0] + off, wanted[1]), *others  # type: ignore[return-value]


@settings(max_examples=300)
@given(st.lists(READINGS, min_size=5, max_size=60), st.booleans())
def test_whatever_is_measured_nothing_is_crushed_dragged_or_dropped(readings: list[Reading], led: bool) -> None:
    now = 0.0
    state = begin_pick(TASK, _measured(now, (0.0, 0.0)))
    command = PickCommand((0.0, 0.0), PASSING, suction=False, image=False)
    for given_reading in readings:
        before, asked = state, command
        reading = _towards(state, given_reading) if led else given_reading
        now += reading[0]
        measured = CellReadings(now, *reading[1:])
        state, command = step_pick(RULES, before, measured)
        if command.height < PASSING:  # lowered, or kept down, only where it should be and still
            assert dist(RULES.tip(measured.angles), RULES.tip(state.phase_angles)) <= RULES.off
            assert all(abs(v) <= RULES.shaken for v in measured.velocities)
        if command.height < min(asked.height, PASSING):  # begins to lower
            assert dist(RULES.tip(measured.angles), RULES.tip(state.phase_angles)) <= RULES.off
        if asked.suction and not command.suction and measured.vacuum >= RULES.lost_vacuum:  # let go
            where = TASK.over_place if state.phase is PickPhase.RELEASE else before.task.over_fruit
            assert state.phase in {PickPhase.RELEASE, PickPhase.RELEASE_BACK}
            assert dist(RULES.tip(measured.angles), RULES.tip(where)) <= RULES.off
            assert command.height < PASSING
        if command.target != asked.target:  # another posture only with the lift up
            passing = CARRYING if command.suction else PASSING
            assert measured.height >= passing - RULES.height
        if command.image:
            assert dist(RULES.tip(measured.angles), RULES.tip(RULES.clear)) <= RULES.near_distance
        if before.phase is not PickPhase.LOWER and state.phase is PickPhase.LOWER:
            assert dist(RULES.tip(measured.angles), RULES.tip(state.phase_angles)) <= RULES.near_distance
            assert all(abs(v) <= RULES.still for v in measured.velocities)


@settings(max_examples=100)
@given(st.lists(READINGS, min_size=5, max_size=30), st.booleans())
def test_every_pick_ends(readings: list[Reading], led: bool) -> None:
    """Whatever repeats itself, for ever."""
    now, k = 0.0, 0
    state = begin_pick(TASK, _measured(now, (0.0, 0.0)))
    while state.phase is not PickPhase.DONE:
        reading = _towards(state, readings[k % len(readings)]) if led else readings[k % len(readings)]
        now, k = now + 0.05, k + 1
        state, _ = step_pick(RULES, state, CellReadings(now, *reading[1:]))
        assert now <= LONGEST + 2.0
    assert state.outcome is not None
