from dataclasses import replace
from math import dist

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.cell.plan.pick import Command, Outcome, Phase, Readings, Relocation, State
from layflat.cell.plan.pick_machine import SUCTION, TRANSITIONS, Event, begun, step
from tests.cell.plan.scripted_plant import CARRYING, CYCLE, LONGEST, PASSING, RULES, TASK, Plant, phases, run

ELSEWHERE = replace(TASK, over_fruit=(0.15, 0.1))


def test_a_pick_goes_its_way_and_lays_the_fruit_into_its_place() -> None:
    plant = Plant()
    state, trace = run(plant)
    assert state.outcome is Outcome.PLACED
    way = [Phase.APPROACH, Phase.LOWER, Phase.SEAL, Phase.LIFT, Phase.CARRY, Phase.PLACE, Phase.RELEASE, Phase.RAISE]
    assert phases(trace) == [*way, Phase.DONE]
    assert len(plant.laid) == 1
    assert plant.laid[0] == pytest.approx(TASK.over_place, abs=1e-9)
    assert state.tried == 1
    assert state.trouble == ""


def test_a_missed_fruit_is_tried_again_where_a_new_picture_shows_it() -> None:
    plant = Plant(fruit={ELSEWHERE.over_fruit: 50e3}, relocations=[Relocation(ELSEWHERE)])
    state, trace = run(plant)
    assert state.outcome is Outcome.PLACED
    assert state.tried == 2
    seen_from = [s for s, command in trace if command.image]
    assert seen_from
    assert all(s.target == RULES.clear for s in seen_from)


def test_after_enough_tries_it_is_missed() -> None:
    state, trace = run(Plant(fruit={}, relocations=[Relocation(TASK)] * 9))
    assert state.outcome is Outcome.MISSED
    assert state.trouble == "no vacuum built up"
    assert phases(trace).count(Phase.LOWER) == RULES.tries


def test_a_fruit_that_a_new_picture_no_longer_shows_is_gone() -> None:
    assert run(Plant(fruit={}, relocations=[Relocation(None)]))[0].outcome is Outcome.GONE


def test_without_a_picture_it_is_stuck() -> None:
    state, _ = run(Plant(fruit={}))
    assert (state.outcome, state.trouble) == (Outcome.STUCK, "no image came")


@pytest.mark.parametrize("phase", [Phase.CARRY, Phase.PLACE])
def test_a_fruit_that_falls_on_its_way_is_lost(phase: Phase) -> None:
    plant = Plant(drops_at=phase)
    state, _ = run(plant)
    assert state.outcome is Outcome.LOST
    assert phase.value in state.trouble
    assert plant.laid == []


def test_a_fruit_that_slips_while_it_is_lifted_is_tried_again() -> None:
    state, trace = run(Plant(drops_at=Phase.LIFT, relocations=[Relocation(TASK)] * 9))
    assert state.outcome is Outcome.MISSED
    assert Phase.CARRY not in phases(trace)
    assert state.trouble == "it slipped off the cup"


def test_two_fruits_in_the_cup_leak_and_are_let_go_where_they_were() -> None:
    plant = Plant(fruit={TASK.over_fruit: 20e3}, relocations=[Relocation(None)])
    state, trace = run(plant)
    assert state.outcome is Outcome.GONE
    assert Phase.LIFT not in phases(trace)
    assert plant.laid[0] == pytest.approx(TASK.over_fruit, abs=1e-3)
    assert "two fruits" in state.trouble


def test_what_is_too_heavy_is_put_back() -> None:
    plant = Plant(lift_speed=0.1, relocations=[Relocation(None)])
    state, trace = run(plant)
    assert state.outcome is Outcome.GONE
    assert Phase.PUT_BACK in phases(trace)
    assert Phase.CARRY not in phases(trace)
    assert plant.laid[0] == pytest.approx(TASK.over_fruit, abs=1e-3)


@pytest.mark.parametrize("top", [0.067, 0.0615, 0.0585, 0.0545])
def test_a_fruit_that_is_higher_or_flatter_than_it_seemed_is_let_go_as_much_higher(top: float) -> None:
    state, trace = run(Plant(top=top))
    assert (state.outcome, state.tried) == (Outcome.PLACED, 1)
    assert state.task.place_height == pytest.approx(TASK.place_height + top - TASK.fruit_height, abs=1e-9)
    assert next(command.height for s, command in trace if s.phase is Phase.PLACE) == state.task.place_height


def test_a_vacuum_that_does_not_go_ends_the_pick_where_the_arm_is() -> None:
    plant = Plant(leaves=False)
    state, trace = run(plant)
    assert (state.outcome, state.trouble) == (Outcome.STUCK, "the vacuum does not decay")
    assert trace[-1][1].target == TASK.over_place


def test_every_phase_is_entered_and_leads_to_the_end() -> None:
    assert set(TRANSITIONS) == set(Phase)
    entered = {Phase.APPROACH, Phase.FOLLOW} | {phase for after in TRANSITIONS.values() for phase in after.values()}
    assert entered == set(Phase)
    ends = {Phase.DONE}
    for _ in Phase:
        ends |= {phase for phase, after in TRANSITIONS.items() if ends & set(after.values())}
    assert ends == set(Phase)
    assert all(Event.STUCK not in after for after in TRANSITIONS.values())  # it ends a pick in any phase


def test_suction_is_switched_off_only_where_a_fruit_is_released_or_lost() -> None:
    for phase, after in TRANSITIONS.items():
        for event, following in after.items():
            if phase in SUCTION and following not in SUCTION | {Phase.DONE}:
                assert following in {Phase.RELEASE, Phase.RELEASE_BACK} or event is Event.DROPPED


def _measured(time: float, angles: tuple[float, ...], **others: object) -> Readings:
    still = Readings(time, angles, (0.0, 0.0), 0.0, CARRYING)
    return replace(still, **others)  # type: ignore[arg-type]


def test_it_waits_until_the_arm_is_near_and_still() -> None:
    state = begun(TASK, _measured(0.0, (0.0, 0.0)))
    over = TASK.over_fruit
    for k in range(40):  # in passing
        state, command = step(RULES, state, _measured(CYCLE * k, over, velocities=(0.5, 0.0)))
        assert state.phase is Phase.APPROACH
    for k in range(40, 60):  # still, but beside
        state, command = step(RULES, state, _measured(CYCLE * k, (over[0] + 0.01, over[1])))
        assert state.phase is Phase.APPROACH
    state, command = step(RULES, state, _measured(0.3, over))
    assert command.height == PASSING
    state, command = step(RULES, state, _measured(0.3 + RULES.dwell, over))
    assert command.height == TASK.fruit_height


def test_an_arm_that_is_pushed_while_the_cup_is_down_is_raised_at_once() -> None:
    for phase in (Phase.LOWER, Phase.SEAL, Phase.PLACE):
        state = State(TASK, phase, 0.0, TASK.over_fruit, suction=True)
        vacuum = 50e3
        pushed = (state.over[0] + 0.02, state.over[1])
        after, command = step(RULES, state, _measured(0.01, pushed, height=0.07, vacuum=vacuum))
        assert command.height == CARRYING
        assert command.suction
        assert after.shaken == 1


def test_an_arm_that_is_pushed_again_and_again_ends_with_the_fruit_held() -> None:
    state, lowered, now = State(TASK, Phase.CARRY, 0.0, TASK.over_place, suction=True), 0, 0.0
    over = TASK.over_place
    while state.phase is not Phase.DONE:
        now += 0.05
        pushed = state.phase is Phase.PLACE
        lowered += pushed
        at = (over[0] + 0.02 * pushed, over[1])
        state, command = step(RULES, state, _measured(now, at, height=0.07 if pushed else CARRYING, vacuum=50e3))
        assert now < LONGEST
    assert lowered == RULES.tries
    assert state.outcome is Outcome.STUCK
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


def _towards(state: State, reading: Reading) -> Reading:
    """The same with the arm about where this phase wants it, so that picks get far."""
    dt, angles, *others = reading
    wanted = RULES.clear if state.phase in {Phase.CLEAR, Phase.AWAIT_IMAGE} else state.over
    off = min((angles[0] - at[0] for at in (TASK.over_fruit, TASK.over_place, RULES.clear)), key=abs)
    return dt, (wanted[0] + off, wanted[1]), *others  # type: ignore[return-value]


@settings(max_examples=300)
@given(st.lists(READINGS, min_size=5, max_size=60), st.booleans())
def test_whatever_is_measured_nothing_is_crushed_dragged_or_dropped(readings: list[Reading], led: bool) -> None:
    now = 0.0
    state = begun(TASK, _measured(now, (0.0, 0.0)))
    command = Command((0.0, 0.0), PASSING, suction=False, image=False)
    for given_reading in readings:
        before, asked = state, command
        reading = _towards(state, given_reading) if led else given_reading
        now += reading[0]
        measured = Readings(now, *reading[1:])
        state, command = step(RULES, before, measured)
        if command.height < PASSING:  # lowered, or kept down, only where it should be and still
            assert dist(RULES.tip(measured.angles), RULES.tip(state.over)) <= RULES.off
            assert all(abs(v) <= RULES.shaken for v in measured.velocities)
        if command.height < min(asked.height, PASSING):  # begins to lower
            assert dist(RULES.tip(measured.angles), RULES.tip(state.over)) <= RULES.off
        if asked.suction and not command.suction and measured.vacuum >= RULES.gone:  # let go
            where = TASK.over_place if state.phase is Phase.RELEASE else before.task.over_fruit
            assert state.phase in {Phase.RELEASE, Phase.RELEASE_BACK}
            assert dist(RULES.tip(measured.angles), RULES.tip(where)) <= RULES.off
            assert command.height < PASSING
        if command.target != asked.target:  # another posture only with the lift up
            passing = CARRYING if command.suction else PASSING
            assert measured.height >= passing - RULES.height
        if command.image:
            assert dist(RULES.tip(measured.angles), RULES.tip(RULES.clear)) <= RULES.near
        if before.phase is not Phase.LOWER and state.phase is Phase.LOWER:
            assert dist(RULES.tip(measured.angles), RULES.tip(state.over)) <= RULES.near
            assert all(abs(v) <= RULES.still for v in measured.velocities)


@settings(max_examples=100)
@given(st.lists(READINGS, min_size=5, max_size=30), st.booleans())
def test_every_pick_ends(readings: list[Reading], led: bool) -> None:
    """Whatever repeats itself, for ever."""
    now, k = 0.0, 0
    state = begun(TASK, _measured(now, (0.0, 0.0)))
    while state.phase is not Phase.DONE:
        reading = _towards(state, readings[k % len(readings)]) if led else readings[k % len(readings)]
        now, k = now + 0.05, k + 1
        state, _ = step(RULES, state, Readings(now, *reading[1:]))
        assert now <= LONGEST + 2.0
    assert state.outcome is not None
