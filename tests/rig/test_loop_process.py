import time

from layflat.machine import load
from layflat.rig.clock import MAX_WARMUPS, WAKE_LEAD, PunctualClock
from layflat.rig.process import READING_COUNT, WarmupLoop
from layflat.rig.safety.faults import Fault, RigState


def test_a_punctual_clock_warms_up_and_never_comes_early() -> None:
    made: list[int] = []
    clock = PunctualClock(lambda: made.append(time.monotonic_ns()))
    until = clock.now() + 3 * WAKE_LEAD
    clock.wait(until)
    assert clock.now() >= until
    assert len(made) <= MAX_WARMUPS
    assert all(until - WAKE_LEAD <= at < until for at in made)


def test_a_punctual_clock_has_no_time_to_rehearse_where_it_comes_late() -> None:
    made: list[int] = []
    clock = PunctualClock(lambda: made.append(0))
    clock.wait(clock.now())
    assert made == []


def test_a_rehearsal_goes_on_like_a_machine_in_motion() -> None:
    warmup = WarmupLoop(load("paper-arm"))
    for _ in range(4 * READING_COUNT):
        warmup()
    loop = warmup.loop
    assert loop.supervisor.state is RigState.MOVING
    assert loop.supervisor.ledger.worst is Fault.NONE
    assert warmup.ring.head.rows.dropped == 0
