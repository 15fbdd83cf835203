import time

from layflat.machine import load
from layflat.rig.clock import LEAD, TIMES, PunctualClock
from layflat.rig.process import READINGS, WarmupLoop
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.states import State


def test_a_punctual_clock_warms_up_and_never_comes_early() -> None:
    made: list[int] = []
    clock = PunctualClock(lambda: made.append(time.monotonic_ns()))
    until = clock.now() + 3 * LEAD
    clock.wait(until)
    assert clock.now() >= until
    assert len(made) <= TIMES
    assert all(until - LEAD <= at < until for at in made)


def test_a_punctual_clock_has_no_time_to_rehearse_where_it_comes_late() -> None:
    made: list[int] = []
    clock = PunctualClock(lambda: made.append(0))
    clock.wait(clock.now())
    assert made == []


def test_a_rehearsal_goes_on_like_a_machine_in_motion() -> None:
    warmup = WarmupLoop(load("paper-arm"))
    for _ in range(4 * READINGS):
        warmup()
    loop = warmup.loop
    assert loop.supervisor.state is State.MOVING
    assert loop.supervisor.ledger.worst is Fault.NONE
    assert warmup.ring.head.rows.dropped == 0
