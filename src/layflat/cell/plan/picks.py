"""The course of a pick, as a pure function of what is measured: `step(rules, state, measured)`.

```
APPROACH -> LOWER -> SUCK -> LIFT -> CARRY -> PLACE -> RELEASE -> RAISE -> DONE
     ^               |        |
     |               v        v too heavy
     |          LET_BACK <- PUT_BACK
     |               v
    LOOK <- CLEAR <- RAISE (missed: a new picture, up to `tries` times)
```

Whatever is measured, three things hold. The lift is lowered only while the tip is where it should be and the arm still.
Another posture is asked for only with the lift up. What is held is let go only in the fruit's place, or where it was.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import dist

from layflat.cell.plan.pick import Command, Measured, Outcome, Phase, Rules, State, Task
from layflat.cell.plan.reach import Angles

DOWN = frozenset({Phase.LOWER, Phase.SUCK, Phase.PLACE, Phase.RELEASE, Phase.PUT_BACK, Phase.LET_BACK})
"""Phases in which the lift is, or goes, down."""


def begun(task: Task, measured: Measured) -> State:
    """A pick that begins with an empty cup."""
    return State(task, Phase.APPROACH, measured.time, measured.angles)


def step(rules: Rules, state: State, measured: Measured) -> tuple[State, Command]:
    """A pick after one cycle, and what it asks for until the next."""
    if state.phase in DOWN and _shaken(rules, state, measured):
        after = _leave(state)
    else:
        after = _COURSE[state.phase](rules, state, measured)
    if after.phase is not state.phase:
        after = replace(after, since=measured.time, near_since=None)
    wanted = _wanted(rules, after)
    up = _up(rules, after, measured)
    # What is down would be dragged.
    target = wanted if up else after.target
    after = replace(after, target=target)
    picture = after.phase is Phase.LOOK and up and _near(rules, rules.clear, measured)
    return after, Command(target, _height(after), after.suction, picture)


def _wanted(rules: Rules, state: State) -> Angles:
    if state.phase in {Phase.CLEAR, Phase.LOOK}:
        return rules.clear
    if state.phase in {Phase.RAISE, Phase.DONE}:
        return state.target
    return state.over


def _height(state: State) -> float:
    if state.phase in {Phase.PLACE, Phase.RELEASE}:
        return state.task.place_height
    if state.phase is Phase.SUCK:
        return state.task.lowest  # a fruit that is flatter than it seemed is felt for
    return state.task.fruit_height if state.phase in DOWN else state.passing


def _up(rules: Rules, state: State, measured: Measured) -> bool:
    """Whether the cup, with what it holds, passes over everything."""
    return measured.height >= state.passing - rules.height


def _down(rules: Rules, state: State, measured: Measured) -> bool:
    """Whether a lift that is lowered is as low as it was asked to be, or has met something on its way."""
    if _up(rules, state, measured):
        return False
    met = abs(measured.lift_speed) <= rules.halted and _lasts(state, measured, rules.starts)
    return met or measured.height <= _height(state) + rules.height


def _near(rules: Rules, posture: Angles, measured: Measured) -> bool:
    """Whether the arm may be lowered at a posture."""
    still = all(abs(v) <= rules.still for v in measured.velocities)
    return still and dist(rules.tip(measured.angles), rules.tip(posture)) <= rules.near


def _shaken(rules: Rules, state: State, measured: Measured) -> bool:
    """Whether a lowered arm has to be raised."""
    moves = any(abs(v) > rules.shaken for v in measured.velocities)
    return moves or dist(rules.tip(measured.angles), rules.tip(state.over)) > rules.off


def _leave(state: State) -> State:
    """The arm moved while the lift was down."""
    told = replace(state, shaken=state.shaken + 1, trouble=f"the arm moved while it {state.phase.value}")
    if state.phase is Phase.PLACE:
        return replace(told, phase=Phase.CARRY)
    if state.phase is Phase.RELEASE:
        return replace(told, phase=Phase.RAISE, outcome=Outcome.LOST)
    if state.phase is Phase.PUT_BACK:
        return _stuck(told, told.trouble)
    # Suction that was on may hold something by now.
    return replace(told, phase=Phase.LIFT if state.suction else Phase.RAISE)


def _stuck(state: State, trouble: str = "") -> State:
    told = trouble or f"it took too long: {state.phase.value}"
    return replace(state, phase=Phase.DONE, outcome=Outcome.STUCK, trouble=told)


def _lasts(state: State, measured: Measured, longest: float) -> bool:
    return measured.time - state.since >= longest


def _arrive(rules: Rules, state: State, measured: Measured, posture: Angles, then: Phase) -> State:
    """Go on once the arm has been near a posture and still for long enough."""
    if not (_up(rules, state, measured) and _near(rules, posture, measured)):
        if _lasts(state, measured, rules.settle_time):
            return _stuck(state, f"the arm does not settle: {state.phase.value}")
        return replace(state, near_since=None)
    since = measured.time if state.near_since is None else state.near_since
    if measured.time - since < rules.dwell - 1e-9:
        return replace(state, near_since=since)
    return replace(state, phase=then)


def _approach(rules: Rules, state: State, measured: Measured) -> State:
    after = _arrive(rules, state, measured, state.task.over_fruit, Phase.LOWER)
    if after.phase is Phase.LOWER:
        return replace(after, suction=True, tried=state.tried + 1, trouble="")
    return after


def _lower(rules: Rules, state: State, measured: Measured) -> State:
    if _down(rules, state, measured) or measured.vacuum >= rules.sound:
        return replace(state, phase=Phase.SUCK)
    return _stuck(state) if _lasts(state, measured, rules.lower_time) else state


def _suck(rules: Rules, state: State, measured: Measured) -> State:
    if measured.vacuum >= rules.sound:
        return replace(state, phase=Phase.LIFT, task=state.task.seated(measured.height))
    if not _lasts(state, measured, rules.suck_time):
        return state
    weak = measured.vacuum >= rules.gone
    trouble = "the vacuum is weak: a leak, or two fruits in the cup" if weak else "nothing was sucked"
    return replace(state, phase=Phase.LET_BACK, suction=False, trouble=trouble)


def _lift(rules: Rules, state: State, measured: Measured) -> State:
    if measured.vacuum < rules.gone:
        return replace(state, phase=Phase.RAISE, suction=False, trouble=state.trouble or "it slipped off the cup")
    if _up(rules, state, measured):
        return replace(state, phase=Phase.CARRY)
    if _lasts(state, measured, rules.heavy_time):
        heavy = "it is lifted too slowly: too heavy, or two fruits"
        if _shaken(rules, state, measured):
            return _stuck(state, heavy)
        return replace(state, phase=Phase.PUT_BACK, trouble=heavy)
    return state


def _carry(rules: Rules, state: State, measured: Measured) -> State:
    if measured.vacuum < rules.gone:
        return _lost(state)
    if state.shaken >= rules.tries:
        return _stuck(state, state.trouble)
    return _arrive(rules, state, measured, state.task.over_place, Phase.PLACE)


def _place(rules: Rules, state: State, measured: Measured) -> State:
    if measured.vacuum < rules.gone:
        return _lost(state)
    if _down(rules, state, measured):
        return replace(state, phase=Phase.RELEASE, suction=False)
    return _stuck(state) if _lasts(state, measured, rules.lower_time) else state


def _lost(state: State) -> State:
    trouble = f"the vacuum went while it {state.phase.value}"
    return replace(state, phase=Phase.RAISE, suction=False, outcome=Outcome.LOST, trouble=trouble)


def _release(rules: Rules, state: State, measured: Measured) -> State:
    if measured.vacuum < rules.empty:
        outcome = Outcome.PLACED if state.phase is Phase.RELEASE else None
        return replace(state, phase=Phase.RAISE, outcome=outcome)
    if _lasts(state, measured, rules.release_time):
        return _stuck(state, "the vacuum does not go")
    return state


def _put_back(rules: Rules, state: State, measured: Measured) -> State:
    if _down(rules, state, measured) or measured.vacuum < rules.gone:
        return replace(state, phase=Phase.LET_BACK, suction=False)
    return _stuck(state) if _lasts(state, measured, rules.lower_time) else state


def _raise(rules: Rules, state: State, measured: Measured) -> State:
    if not _up(rules, state, measured):
        return _stuck(state) if _lasts(state, measured, rules.raise_time) else state
    if state.outcome is not None:
        return replace(state, phase=Phase.DONE)
    if state.tried >= rules.tries:
        return replace(state, phase=Phase.DONE, outcome=Outcome.MISSED)
    return replace(state, phase=Phase.CLEAR)


def _clear(rules: Rules, state: State, measured: Measured) -> State:
    return _arrive(rules, state, measured, rules.clear, Phase.LOOK)


def _look(rules: Rules, state: State, measured: Measured) -> State:
    if measured.sighting is None:
        return _stuck(state, "no picture came") if _lasts(state, measured, rules.look_time) else state
    if measured.sighting.task is None:
        return replace(state, phase=Phase.DONE, outcome=Outcome.GONE)
    return replace(state, phase=Phase.APPROACH, task=measured.sighting.task)


def _done(rules: Rules, state: State, measured: Measured) -> State:  # noqa: ARG001  (as all phases)
    return state


_COURSE: dict[Phase, Callable[[Rules, State, Measured], State]] = {
    Phase.APPROACH: _approach,
    Phase.LOWER: _lower,
    Phase.SUCK: _suck,
    Phase.LIFT: _lift,
    Phase.CARRY: _carry,
    Phase.PLACE: _place,
    Phase.RELEASE: _release,
    Phase.PUT_BACK: _put_back,
    Phase.LET_BACK: _release,
    Phase.RAISE: _raise,
    Phase.CLEAR: _clear,
    Phase.LOOK: _look,
    Phase.DONE: _done,
}
