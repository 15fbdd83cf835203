"""The state machine of a pick, as a pure function of what is measured: `step(rules, state, measured)`.

Each phase has a rule that says which event has happened, if any; `TRANSITIONS` is the one place that says which phase
follows, drawn in docs/cell-plan.md. Whatever is measured, three things hold. The lift is lowered only while the tip is
where it should be and the arm still. Another posture is commanded only with the lift up. What is held is released only
in the fruit's place, or where it was.
"""

from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from math import dist

from layflat.cell.plan.pick import Command, Moving, Outcome, Phase, Readings, Rules, State, Task
from layflat.motion.reach import Angles

Event = Enum(
    "Event", "SETTLED CONTACT SEALED NO_SEAL RAISED DROPPED HEAVY RELEASED DISTURBED LEFT RELOCATED ENDED STUCK"
)
"""What ends a phase."""

TRANSITIONS: dict[Phase, dict[Event, Phase]] = {
    Phase.APPROACH: {Event.SETTLED: Phase.LOWER},
    Phase.FOLLOW: {Event.SETTLED: Phase.LOWER, Event.LEFT: Phase.RAISE},
    # Suction that was on may hold something by now: an arm that is disturbed, or stops at its reach, lifts it.
    Phase.LOWER: {Event.CONTACT: Phase.SEAL, Event.DISTURBED: Phase.LIFT, Event.LEFT: Phase.LIFT},
    Phase.SEAL: {
        Event.SEALED: Phase.LIFT,
        Event.NO_SEAL: Phase.RELEASE_BACK,
        Event.DISTURBED: Phase.LIFT,
        Event.LEFT: Phase.LIFT,
    },
    Phase.LIFT: {Event.RAISED: Phase.CARRY, Event.DROPPED: Phase.RAISE, Event.HEAVY: Phase.PUT_BACK},
    Phase.CARRY: {Event.SETTLED: Phase.PLACE, Event.DROPPED: Phase.RAISE},
    Phase.PLACE: {Event.CONTACT: Phase.RELEASE, Event.DROPPED: Phase.RAISE, Event.DISTURBED: Phase.CARRY},
    Phase.RELEASE: {Event.RELEASED: Phase.RAISE, Event.DISTURBED: Phase.RAISE},
    Phase.PUT_BACK: {Event.CONTACT: Phase.RELEASE_BACK, Event.DISTURBED: Phase.DONE},
    Phase.RELEASE_BACK: {Event.RELEASED: Phase.RAISE, Event.DISTURBED: Phase.RAISE},
    Phase.RAISE: {Event.RAISED: Phase.CLEAR, Event.ENDED: Phase.DONE},
    Phase.CLEAR: {Event.SETTLED: Phase.AWAIT_IMAGE},
    Phase.AWAIT_IMAGE: {Event.RELOCATED: Phase.APPROACH, Event.ENDED: Phase.DONE},
    Phase.DONE: {},
}
"""The phase that follows an event; `Event.STUCK` ends a pick in any phase."""

DOWN = frozenset({Phase.LOWER, Phase.SEAL, Phase.PLACE, Phase.RELEASE, Phase.PUT_BACK, Phase.RELEASE_BACK})
"""Phases in which the lift is, or goes, down."""

SUCTION = frozenset({Phase.LOWER, Phase.SEAL, Phase.LIFT, Phase.CARRY, Phase.PLACE, Phase.PUT_BACK})
"""Phases with suction on; a pick that is done keeps what it had."""

LEAVES = frozenset({Phase.FOLLOW, Phase.LOWER, Phase.SEAL})
"""Phases in which a fruit that moves may get away."""

OVER_FRUIT = frozenset({
    Phase.FOLLOW, Phase.LOWER, Phase.SEAL, Phase.LIFT, Phase.PUT_BACK, Phase.RELEASE_BACK
})  # fmt: skip
"""Phases in which the arm goes with a fruit that moves."""

Found = tuple[Event | None, State]
"""What has happened, if anything, and the state with what is known by it, still in the same phase."""


def begun(task: Task, measured: Readings) -> State:
    """Return a pick that begins with an empty cup."""
    phase = Phase.APPROACH if measured.moving is None else Phase.FOLLOW
    return State(task, phase, measured.time, measured.angles)


def step(rules: Rules, state: State, measured: Readings) -> tuple[State, Command]:
    """Return a pick after one cycle, and what it commands until the next."""
    follows = measured.moving is not None and state.phase in OVER_FRUIT
    if measured.moving is not None and follows:
        state, measured = _beside(state, measured, measured.moving)
    if measured.moving is not None and measured.moving.trouble and state.phase in LEAVES:
        event, after = _ended(Event.LEFT, state, None, measured.moving.trouble)
    elif state.phase in DOWN and _shaken(rules, state, measured):
        event, after = _disturbed(state)
    else:
        event, after = _RULES[state.phase](rules, state, measured)
    if event is not None:
        phase = Phase.DONE if event is Event.STUCK else TRANSITIONS[state.phase][event]
        suction = after.suction if phase is Phase.DONE else phase in SUCTION
        after = replace(after, phase=phase, suction=suction, since=measured.time, near_since=None)
    up = _up(rules, after, measured)
    follows = measured.moving is not None and after.phase in OVER_FRUIT
    # What is down would be dragged, unless what it is on moves too.
    after = replace(after, target=_posture(rules, after) if up or follows else after.target)
    image = after.phase is Phase.AWAIT_IMAGE and up and _near(rules, rules.clear, measured)
    follows = follows and measured.moving is not None and not measured.moving.trouble
    return after, Command(after.target, _height(after), after.suction, image, follows)


def _beside(state: State, measured: Readings, moving: Moving) -> tuple[State, Readings]:
    """Return state and measurements as they are beside a fruit that moves: the arm is to go with it."""
    relative = tuple(v - of_fruit for v, of_fruit in zip(measured.velocities, moving.velocities, strict=True))
    return replace(state, task=replace(state.task, over_fruit=moving.over)), replace(measured, velocities=relative)


def _posture(rules: Rules, state: State) -> Angles:
    if state.phase in {Phase.CLEAR, Phase.AWAIT_IMAGE}:
        return rules.clear
    return state.target if state.phase in {Phase.RAISE, Phase.DONE} else state.over


def _height(state: State) -> float:
    if state.phase in {Phase.PLACE, Phase.RELEASE}:
        return state.task.place_height
    if state.phase is Phase.SEAL:
        return state.task.lowest  # a fruit that is flatter than it seemed is felt for
    return state.task.fruit_height if state.phase in DOWN else state.passing


def _up(rules: Rules, state: State, measured: Readings) -> bool:
    """Return whether the cup, with what it holds, passes over everything."""
    return measured.height >= state.passing - rules.height


def _down(rules: Rules, state: State, measured: Readings) -> bool:
    """Return whether a lift that is lowered is as low as commanded, or has met something on its way."""
    if _up(rules, state, measured):
        return False
    met = abs(measured.lift_speed) <= rules.halted and measured.time - state.since >= rules.starts
    return met or measured.height <= _height(state) + rules.height


def _near(rules: Rules, posture: Angles, measured: Readings) -> bool:
    """Return whether the arm may be lowered at a posture."""
    still = all(abs(v) <= rules.still for v in measured.velocities)
    return still and dist(rules.tip(measured.angles), rules.tip(posture)) <= rules.near


def _shaken(rules: Rules, state: State, measured: Readings) -> bool:
    """Return whether a lowered arm has to be raised."""
    moves = any(abs(v) > rules.shaken for v in measured.velocities)
    return moves or dist(rules.tip(measured.angles), rules.tip(state.over)) > rules.off


def _ended(event: Event, state: State, outcome: Outcome | None, trouble: str) -> Found:
    return event, replace(state, outcome=outcome, trouble=trouble)


def _waiting(state: State, measured: Readings, longest: float, trouble: str = "") -> Found:
    """Wait on, up to a time (s)."""
    if measured.time - state.since < longest:
        return None, state
    return _ended(Event.STUCK, state, Outcome.STUCK, trouble or f"it took too long: the arm {state.phase.value}")


def _disturbed(state: State) -> Found:
    """The arm moved while the lift was down."""
    outcome = {Phase.RELEASE: Outcome.LOST, Phase.PUT_BACK: Outcome.STUCK}.get(state.phase)
    after = replace(state, shaken=state.shaken + 1)
    return _ended(Event.DISTURBED, after, outcome, f"the arm moved while it {state.phase.value}")


def _settling(rules: Rules, state: State, measured: Readings, posture: Angles) -> Found:
    """The arm has settled once it has been near a posture and still for long enough."""
    if not (_up(rules, state, measured) and _near(rules, posture, measured)):
        event, after = _waiting(state, measured, rules.settle_time, f"the arm does not settle: it {state.phase.value}")
        return event, replace(after, near_since=None)
    since = measured.time if state.near_since is None else state.near_since
    settled = measured.time - since >= rules.dwell - 1e-9
    return Event.SETTLED if settled else None, replace(state, near_since=since)


def _approach(rules: Rules, state: State, measured: Readings) -> Found:
    event, after = _settling(rules, state, measured, state.task.over_fruit)
    return event, replace(after, tried=state.tried + 1, trouble="") if event is Event.SETTLED else after


def _follow(rules: Rules, state: State, measured: Readings) -> Found:
    event, after = _approach(rules, state, measured)
    return (Event.LEFT, replace(after, outcome=None)) if event is Event.STUCK else (event, after)


def _lower(rules: Rules, state: State, measured: Readings) -> Found:
    """The cup comes down: on the fruit, with it into its place, or with it to where it was."""
    holds = measured.vacuum >= rules.gone
    if state.phase is Phase.PLACE and not holds:
        return _lost(state)
    felt = {Phase.LOWER: measured.vacuum >= rules.sound, Phase.PUT_BACK: not holds}
    if _down(rules, state, measured) or felt.get(state.phase, False):
        return Event.CONTACT, state
    return _waiting(state, measured, rules.lower_time)


def _seal(rules: Rules, state: State, measured: Readings) -> Found:
    if measured.vacuum >= rules.sound:
        return Event.SEALED, replace(state, task=state.task.seated(measured.height))
    if measured.time - state.since < rules.seal_time:
        return None, state
    weak = measured.vacuum >= rules.gone
    trouble = "the vacuum is weak: a leak, or two fruits in the cup" if weak else "no vacuum built up"
    return Event.NO_SEAL, replace(state, trouble=trouble)


def _lift(rules: Rules, state: State, measured: Readings) -> Found:
    if measured.vacuum < rules.gone:
        return Event.DROPPED, replace(state, trouble=state.trouble or "it slipped off the cup")
    if _up(rules, state, measured):
        return Event.RAISED, state
    if measured.time - state.since < rules.heavy_time:
        return None, state
    heavy = "it is lifted too slowly: too heavy, or two fruits"
    if _shaken(rules, state, measured):
        return _ended(Event.STUCK, state, Outcome.STUCK, heavy)
    return Event.HEAVY, replace(state, trouble=heavy)


def _carry(rules: Rules, state: State, measured: Readings) -> Found:
    if measured.vacuum < rules.gone:
        return _lost(state)
    if state.shaken >= rules.tries:
        return _ended(Event.STUCK, state, Outcome.STUCK, state.trouble)
    return _settling(rules, state, measured, state.task.over_place)


def _lost(state: State) -> Found:
    return _ended(Event.DROPPED, state, Outcome.LOST, f"the vacuum was lost while the arm {state.phase.value}")


def _release(rules: Rules, state: State, measured: Readings) -> Found:
    if measured.vacuum < rules.empty:
        return Event.RELEASED, replace(state, outcome=Outcome.PLACED if state.phase is Phase.RELEASE else None)
    return _waiting(state, measured, rules.release_time, "the vacuum does not decay")


def _raise(rules: Rules, state: State, measured: Readings) -> Found:
    if not _up(rules, state, measured):
        return _waiting(state, measured, rules.raise_time)
    # What moves is chosen anew, where it is by then.
    if state.outcome is None and state.tried < rules.tries and measured.moving is None:
        return Event.RAISED, state
    return Event.ENDED, replace(state, outcome=state.outcome or Outcome.MISSED)


def _await_image(rules: Rules, state: State, measured: Readings) -> Found:
    if measured.relocation is None:
        return _waiting(state, measured, rules.image_time, "no image came")
    if measured.relocation.task is None:
        return Event.ENDED, replace(state, outcome=Outcome.GONE)
    return Event.RELOCATED, replace(state, task=measured.relocation.task)


_RULES: dict[Phase, Callable[[Rules, State, Readings], Found]] = {
    Phase.APPROACH: _approach,
    Phase.FOLLOW: _follow,
    Phase.LOWER: _lower,
    Phase.SEAL: _seal,
    Phase.LIFT: _lift,
    Phase.CARRY: _carry,
    Phase.PLACE: _lower,
    Phase.RELEASE: _release,
    Phase.PUT_BACK: _lower,
    Phase.RELEASE_BACK: _release,
    Phase.RAISE: _raise,
    Phase.CLEAR: lambda rules, state, measured: _settling(rules, state, measured, rules.clear),
    Phase.AWAIT_IMAGE: _await_image,
    Phase.DONE: lambda rules, state, measured: (None, state),  # noqa: ARG005  (as all phases)
}
