"""State machine of a pick, as a pure function of sensor readings: `step_pick(rules, state, measured)`.

Each phase has a rule that returns the event that has happened, if any; `NEXT_PHASES` alone says which phase follows,
drawn in docs/cell-plan.md. Whatever is measured, three invariants hold. The lift is lowered only while the tip is at
its target and the arm stationary. Other joint angles are commanded only with the lift up. A held fruit is released
only in its place, or where it was.
"""

from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from math import dist

from layflat.cell.plan.pick import (
    CellReadings,
    MovingFruit,
    PickCommand,
    PickOutcome,
    PickPhase,
    PickRules,
    PickState,
    PickTask,
)
from layflat.motion.planar import Angles

PickEvent = Enum(
    "PickEvent", "SETTLED CONTACT SEALED NO_SEAL RAISED DROPPED HEAVY RELEASED DISTURBED LEFT RELOCATED ENDED STUCK"
)
"""Event that ends a phase."""

NEXT_PHASES: dict[PickPhase, dict[PickEvent, PickPhase]] = {
    PickPhase.APPROACH: {PickEvent.SETTLED: PickPhase.LOWER},
    PickPhase.FOLLOW: {PickEvent.SETTLED: PickPhase.LOWER, PickEvent.LEFT: PickPhase.RAISE},
    # The cup may hold something already: an arm that is disturbed, or stops at its reach, lifts it.
    PickPhase.LOWER: {
        PickEvent.CONTACT: PickPhase.SEAL,
        PickEvent.DISTURBED: PickPhase.LIFT,
        PickEvent.LEFT: PickPhase.LIFT,
    },
    PickPhase.SEAL: {
        PickEvent.SEALED: PickPhase.LIFT,
        PickEvent.NO_SEAL: PickPhase.RELEASE_BACK,
        PickEvent.DISTURBED: PickPhase.LIFT,
        PickEvent.LEFT: PickPhase.LIFT,
    },
    PickPhase.LIFT: {
        PickEvent.RAISED: PickPhase.CARRY,
        PickEvent.DROPPED: PickPhase.RAISE,
        PickEvent.HEAVY: PickPhase.PUT_BACK,
    },
    PickPhase.CARRY: {PickEvent.SETTLED: PickPhase.PLACE, PickEvent.DROPPED: PickPhase.RAISE},
    PickPhase.PLACE: {
        PickEvent.CONTACT: PickPhase.RELEASE,
        PickEvent.DROPPED: PickPhase.RAISE,
        PickEvent.DISTURBED: PickPhase.CARRY,
    },
    PickPhase.RELEASE: {PickEvent.RELEASED: PickPhase.RAISE, PickEvent.DISTURBED: PickPhase.RAISE},
    PickPhase.PUT_BACK: {PickEvent.CONTACT: PickPhase.RELEASE_BACK, PickEvent.DISTURBED: PickPhase.DONE},
    PickPhase.RELEASE_BACK: {PickEvent.RELEASED: PickPhase.RAISE, PickEvent.DISTURBED: PickPhase.RAISE},
    PickPhase.RAISE: {PickEvent.RAISED: PickPhase.CLEAR, PickEvent.ENDED: PickPhase.DONE},
    PickPhase.CLEAR: {PickEvent.SETTLED: PickPhase.AWAIT_IMAGE},
    PickPhase.AWAIT_IMAGE: {PickEvent.RELOCATED: PickPhase.APPROACH, PickEvent.ENDED: PickPhase.DONE},
    PickPhase.DONE: {},
}
"""Next phase by phase and event; `PickEvent.STUCK` ends a pick in any phase."""

LOWERED_PHASES = frozenset(
    {PickPhase.LOWER, PickPhase.SEAL, PickPhase.PLACE, PickPhase.RELEASE, PickPhase.PUT_BACK, PickPhase.RELEASE_BACK}
)
"""Phases in which the lift is lowered, or being lowered."""

SUCTION_PHASES = frozenset(
    {PickPhase.LOWER, PickPhase.SEAL, PickPhase.LIFT, PickPhase.CARRY, PickPhase.PLACE, PickPhase.PUT_BACK}
)
"""Phases with suction on; DONE keeps that of the phase before."""

ESCAPE_PHASES = frozenset({PickPhase.FOLLOW, PickPhase.LOWER, PickPhase.SEAL})
"""Phases in which a moving fruit may leave the arm's reach."""

FRUIT_PHASES = frozenset({
    PickPhase.FOLLOW, PickPhase.LOWER, PickPhase.SEAL, PickPhase.LIFT, PickPhase.PUT_BACK, PickPhase.RELEASE_BACK
})  # fmt: skip
"""Phases in which the arm follows a moving fruit."""

PhaseResult = tuple[PickEvent | None, PickState]
"""Event that has happened, if any, and the updated state, still in the same phase."""


def begin_pick(task: PickTask, measured: CellReadings) -> PickState:
    """Return the first state of a pick: APPROACH, or FOLLOW for a moving fruit, with an empty cup and the arm held."""
    phase = PickPhase.APPROACH if measured.moving is None else PickPhase.FOLLOW
    return PickState(task, phase, measured.time, measured.angles)


def step_pick(rules: PickRules, state: PickState, measured: CellReadings) -> tuple[PickState, PickCommand]:
    """Advance a pick by one control cycle.

    Args:
        rules: thresholds and time limits.
        state: after the last cycle.
        measured: sensor readings of this cycle.

    Returns:
        The new state, and the command until the next cycle.
    """
    follows = measured.moving is not None and state.phase in FRUIT_PHASES
    if measured.moving is not None and follows:
        state, measured = _relative_to_fruit(state, measured, measured.moving)
    if measured.moving is not None and measured.moving.trouble and state.phase in ESCAPE_PHASES:
        event, after = _end_phase(PickEvent.LEFT, state, None, measured.moving.trouble)
    elif state.phase in LOWERED_PHASES and _is_disturbed(rules, state, measured):
        event, after = _note_disturbance(state)
    else:
        event, after = _PHASE_RULES[state.phase](rules, state, measured)
    if event is not None:
        phase = PickPhase.DONE if event is PickEvent.STUCK else NEXT_PHASES[state.phase][event]
        suction = after.suction if phase is PickPhase.DONE else phase in SUCTION_PHASES
        after = replace(after, phase=phase, suction=suction, since=measured.time, near_since=None)
    up = _is_raised(rules, after, measured)
    follows = measured.moving is not None and after.phase in FRUIT_PHASES
    # A lowered cup would drag the touched fruit, unless that moves with the arm.
    after = replace(after, target=_target_angles(rules, after) if up or follows else after.target)
    image = after.phase is PickPhase.AWAIT_IMAGE and up and _is_stationary_at(rules, rules.clear, measured)
    follows = follows and measured.moving is not None and not measured.moving.trouble
    return after, PickCommand(after.target, _demanded_height(after), after.suction, image, follows)


def _relative_to_fruit(state: PickState, measured: CellReadings, moving: MovingFruit) -> tuple[PickState, CellReadings]:
    """Return state and readings relative to a moving fruit: target over it, velocities relative to its own."""
    relative = tuple(v - of_fruit for v, of_fruit in zip(measured.velocities, moving.velocities, strict=True))
    return replace(state, task=replace(state.task, over_fruit=moving.over)), replace(measured, velocities=relative)


def _target_angles(rules: PickRules, state: PickState) -> Angles:
    """Return the joint angles (rad) that the phase demands; RAISE and DONE keep the present target."""
    if state.phase in {PickPhase.CLEAR, PickPhase.AWAIT_IMAGE}:
        return rules.clear
    return state.target if state.phase in {PickPhase.RAISE, PickPhase.DONE} else state.phase_angles


def _demanded_height(state: PickState) -> float:
    """Return the height (m) of the cup that the present phase demands."""
    if state.phase in {PickPhase.PLACE, PickPhase.RELEASE}:
        return state.task.place_height
    if state.phase is PickPhase.SEAL:
        return state.task.lowest  # the fruit may be flatter than estimated
    return state.task.fruit_height if state.phase in LOWERED_PHASES else state.passing


def _is_raised(rules: PickRules, state: PickState, measured: CellReadings) -> bool:
    """Return whether the cup and its fruit are above all obstacles."""
    return measured.height >= state.passing - rules.height


def _is_lowered(rules: PickRules, state: PickState, measured: CellReadings) -> bool:
    """Return whether a lift that is being lowered has arrived at its commanded height, or has touched something."""
    if _is_raised(rules, state, measured):
        return False
    stopped = abs(measured.lift_speed) <= rules.halted and measured.time - state.since >= rules.starts
    return stopped or measured.height <= _demanded_height(state) + rules.height


def _is_stationary_at(rules: PickRules, target: Angles, measured: CellReadings) -> bool:
    """Return whether every joint is slower than `still`, and the tip within `near_distance` of that at the target."""
    stationary = all(abs(v) <= rules.still for v in measured.velocities)
    return stationary and dist(rules.tip(measured.angles), rules.tip(target)) <= rules.near_distance


def _is_disturbed(rules: PickRules, state: PickState, measured: CellReadings) -> bool:
    """Return whether a joint is faster than `shaken`, or the tip farther than `off` from that at the phase's angles."""
    moves = any(abs(v) > rules.shaken for v in measured.velocities)
    return moves or dist(rules.tip(measured.angles), rules.tip(state.phase_angles)) > rules.off


def _end_phase(event: PickEvent, state: PickState, outcome: PickOutcome | None, trouble: str) -> PhaseResult:
    """Return an event that ends the phase, and the state with outcome and trouble."""
    return event, replace(state, outcome=outcome, trouble=trouble)


def _wait(state: PickState, measured: CellReadings, time_limit: float, trouble: str = "") -> PhaseResult:
    """Return no event within a time limit (s) of the phase, then STUCK with this trouble, or a general one."""
    if measured.time - state.since < time_limit:
        return None, state
    return _end_phase(
        PickEvent.STUCK, state, PickOutcome.STUCK, trouble or f"it took too long: the arm {state.phase.value}"
    )


def _note_disturbance(state: PickState) -> PhaseResult:
    """Return DISTURBED, with the disturbance counted; the outcome is LOST in RELEASE, STUCK in PUT_BACK, else open."""
    outcome = {PickPhase.RELEASE: PickOutcome.LOST, PickPhase.PUT_BACK: PickOutcome.STUCK}.get(state.phase)
    after = replace(state, shaken=state.shaken + 1)
    return _end_phase(PickEvent.DISTURBED, after, outcome, f"the arm moved while it {state.phase.value}")


def _settle(rules: PickRules, state: PickState, measured: CellReadings, target: Angles) -> PhaseResult:
    """Return SETTLED once the arm has been stationary at a target for `dwell`, lift up; STUCK after `settle_time`."""
    if not (_is_raised(rules, state, measured) and _is_stationary_at(rules, target, measured)):
        event, after = _wait(state, measured, rules.settle_time, f"the arm does not settle: it {state.phase.value}")
        return event, replace(after, near_since=None)
    since = measured.time if state.near_since is None else state.near_since
    settled = measured.time - since >= rules.dwell - 1e-9
    return PickEvent.SETTLED if settled else None, replace(state, near_since=since)


def _approach(rules: PickRules, state: PickState, measured: CellReadings) -> PhaseResult:
    """Wait until the arm has settled over the fruit, then count an attempt and clear the trouble."""
    event, after = _settle(rules, state, measured, state.task.over_fruit)
    return event, replace(after, tried=state.tried + 1, trouble="") if event is PickEvent.SETTLED else after


def _follow(rules: PickRules, state: PickState, measured: CellReadings) -> PhaseResult:
    """Wait as in APPROACH, relative to the moving fruit; LEFT in place of STUCK."""
    event, after = _approach(rules, state, measured)
    return (PickEvent.LEFT, replace(after, outcome=None)) if event is PickEvent.STUCK else (event, after)


def _lower(rules: PickRules, state: PickState, measured: CellReadings) -> PhaseResult:
    """Wait for CONTACT of the lowered cup, or of its fruit with the place or old position: by stop, height or vacuum.

    DROPPED where the vacuum is lost in PLACE, STUCK after `lower_time`.
    """
    holds = measured.vacuum >= rules.lost_vacuum
    if state.phase is PickPhase.PLACE and not holds:
        return _lose_fruit(state)
    contact_by_vacuum = {PickPhase.LOWER: measured.vacuum >= rules.sound, PickPhase.PUT_BACK: not holds}
    if _is_lowered(rules, state, measured) or contact_by_vacuum.get(state.phase, False):
        return PickEvent.CONTACT, state
    return _wait(state, measured, rules.lower_time)


def _await_seal(rules: PickRules, state: PickState, measured: CellReadings) -> PhaseResult:
    """Wait in phase SEAL until the vacuum is `sound`, which sets the task's heights; NO_SEAL after `seal_time`."""
    if measured.vacuum >= rules.sound:
        return PickEvent.SEALED, replace(state, task=state.task.seated(measured.height))
    if measured.time - state.since < rules.seal_time:
        return None, state
    weak = measured.vacuum >= rules.lost_vacuum
    trouble = "the vacuum is weak: a leak, or two fruits in the cup" if weak else "no vacuum built up"
    return PickEvent.NO_SEAL, replace(state, trouble=trouble)


def _await_lift(rules: PickRules, state: PickState, measured: CellReadings) -> PhaseResult:
    """Wait in phase LIFT until the fruit is raised; DROPPED on loss of vacuum, after `heavy_time` HEAVY.

    With a disturbed arm it is STUCK in place of HEAVY.
    """
    if measured.vacuum < rules.lost_vacuum:
        return PickEvent.DROPPED, replace(state, trouble=state.trouble or "it slipped off the cup")
    if _is_raised(rules, state, measured):
        return PickEvent.RAISED, state
    if measured.time - state.since < rules.heavy_time:
        return None, state
    heavy = "it is lifted too slowly: too heavy, or two fruits"
    if _is_disturbed(rules, state, measured):
        return _end_phase(PickEvent.STUCK, state, PickOutcome.STUCK, heavy)
    return PickEvent.HEAVY, replace(state, trouble=heavy)


def _await_arrival(rules: PickRules, state: PickState, measured: CellReadings) -> PhaseResult:
    """Wait in phase CARRY until the arm has settled over the place; DROPPED on loss of vacuum.

    STUCK after `tries` disturbances, or as `_settle`.
    """
    if measured.vacuum < rules.lost_vacuum:
        return _lose_fruit(state)
    if state.shaken >= rules.tries:
        return _end_phase(PickEvent.STUCK, state, PickOutcome.STUCK, state.trouble)
    return _settle(rules, state, measured, state.task.over_place)


def _lose_fruit(state: PickState) -> PhaseResult:
    """Return DROPPED, with outcome LOST, for a vacuum that is lost in this phase."""
    return _end_phase(
        PickEvent.DROPPED, state, PickOutcome.LOST, f"the vacuum was lost while the arm {state.phase.value}"
    )


def _await_release(rules: PickRules, state: PickState, measured: CellReadings) -> PhaseResult:
    """Wait until the vacuum has decayed; RELEASED, with outcome PLACED in RELEASE; STUCK after `release_time`."""
    if measured.vacuum < rules.empty:
        return PickEvent.RELEASED, replace(
            state, outcome=PickOutcome.PLACED if state.phase is PickPhase.RELEASE else None
        )
    return _wait(state, measured, rules.release_time, "the vacuum does not decay")


def _await_raised(rules: PickRules, state: PickState, measured: CellReadings) -> PhaseResult:
    """Wait until the empty cup is raised: RAISED to try again, if `tries` and a fruit at rest allow it, else ENDED."""
    if not _is_raised(rules, state, measured):
        return _wait(state, measured, rules.raise_time)
    # A moving fruit is not tried again in this pick: it is chosen again at its new position.
    if state.outcome is None and state.tried < rules.tries and measured.moving is None:
        return PickEvent.RAISED, state
    return PickEvent.ENDED, replace(state, outcome=state.outcome or PickOutcome.MISSED)


def _await_image(rules: PickRules, state: PickState, measured: CellReadings) -> PhaseResult:
    """Wait for the new estimate of the fruit; RELOCATED, or ENDED with outcome GONE if it is not detected."""
    if measured.relocation is None:
        return _wait(state, measured, rules.image_time, "no image came")
    if measured.relocation.task is None:
        return PickEvent.ENDED, replace(state, outcome=PickOutcome.GONE)
    return PickEvent.RELOCATED, replace(state, task=measured.relocation.task)


_PHASE_RULES: dict[PickPhase, Callable[[PickRules, PickState, CellReadings], PhaseResult]] = {
    PickPhase.APPROACH: _approach,
    PickPhase.FOLLOW: _follow,
    PickPhase.LOWER: _lower,
    PickPhase.SEAL: _await_seal,
    PickPhase.LIFT: _await_lift,
    PickPhase.CARRY: _await_arrival,
    PickPhase.PLACE: _lower,
    PickPhase.RELEASE: _await_release,
    PickPhase.PUT_BACK: _lower,
    PickPhase.RELEASE_BACK: _await_release,
    PickPhase.RAISE: _await_raised,
    PickPhase.CLEAR: lambda rules, state, measured: _settle(rules, state, measured, rules.clear),
    PickPhase.AWAIT_IMAGE: _await_image,
    PickPhase.DONE: lambda rules, state, measured: (None, state),  # noqa: ARG005  (as all phases)
}
