import multiprocessing
import os
import signal
import time
from dataclasses import replace
from math import isnan, nan
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.machine.interface import MAX_OUTPUTS
from layflat.rig.clock import NS_PER_SECOND, VirtualClock
from layflat.rig.mailbox import SLOT_HEADER, Mailbox, RemoteHost, Setpoints
from layflat.rig.record import RowLayout
from layflat.rig.system import MAILBOX_PREFIX, MIN_MAILBOX_AGE, remove_orphaned_files

LAYOUT = RowLayout(("a", "b"), (("phase", ("1", "phase")),))
WIDTH = LAYOUT.width


@pytest.fixture
def path() -> object:
    made = Mailbox.create(LAYOUT)
    yield made
    made.unlink()


def hammer(path: Path) -> None:
    box, k = Mailbox(path, LAYOUT), 0
    while True:
        k += 1
        box.write_setpoints(Setpoints([float(k), -float(k)], k, k, k))
        box.publish(np.full(WIDTH, float(k)))


def test_no_message_is_ever_torn_and_a_writer_may_die_at_any_time(path: Path) -> None:
    box, context = Mailbox(path, LAYOUT), multiprocessing.get_context("spawn")
    for _ in range(2):
        process = context.Process(target=hammer, args=(path,), daemon=True)
        process.start()
        seen: set[int] = set()
        until = time.monotonic() + 20.0
        while len(seen) < 50 and time.monotonic() < until:
            found, row = box.read_setpoints(), box.read_row()
            if found is not None:
                wanted = found[1]
                assert wanted.demands == [wanted.starts, -wanted.starts]
                assert wanted.starts == wanted.stops == wanted.resets
                seen.add(wanted.starts)
            if row is not None:
                assert (row == row[0]).all()
        assert len(seen) >= 50
        assert process.pid is not None
        os.kill(process.pid, signal.SIGKILL)
        process.join()
    box.write_setpoints(Setpoints([1.0, 2.0]))
    found = box.read_setpoints()
    assert found is not None
    assert found[1].demands == [1.0, 2.0]


@given(st.binary(min_size=1, max_size=64), st.integers(0, 200))
def test_a_spoilt_message_is_not_taken(rubbish: bytes, at: int) -> None:
    path = Mailbox.create(LAYOUT)
    try:
        box = Mailbox(path, LAYOUT)
        box.write_setpoints(Setpoints([0.25, 0.5], 3))
        end = SLOT_HEADER.size + 8 * (7 + MAX_OUTPUTS)
        at = min(at, end - 1)
        before = bytes(box._memory[:end])
        box._memory[at : min(at + len(rubbish), end)] = rubbish[: end - at]
        found = box.read_setpoints()
        # Padding aside, either nothing changed or nothing is taken.
        if found is not None:
            assert found[1] == Setpoints([0.25, 0.5], 3)
            assert bytes(box._memory[SLOT_HEADER.size : end]) == before[SLOT_HEADER.size :]
    finally:
        path.unlink()


def test_edges_are_given_once_and_age_is_by_the_loops_clock(path: Path) -> None:
    box, clock = Mailbox(path, LAYOUT), VirtualClock()
    host = RemoteHost(Mailbox(path, LAYOUT), clock, 2)
    assert all(isnan(demand) for demand in host.request(0).demands)
    box.write_setpoints(Setpoints([nan, 1.0], starts=2, resets=1))
    first, second = host.request(NS_PER_SECOND), host.request(NS_PER_SECOND + NS_PER_SECOND // 20)
    assert (first.start, first.stop, first.reset, first.age) == (True, False, True, 0.0)
    assert (second.start, second.reset) == (False, False)
    assert second.age == pytest.approx(0.05)
    box.write_setpoints(Setpoints([nan, 1.0], starts=2, resets=1))
    assert host.request(2 * NS_PER_SECOND).age == 0.0
    clock.wait(3 * NS_PER_SECOND)
    assert not host.ended
    clock.wait(5 * NS_PER_SECOND)
    assert host.ended


def test_digital_outputs_are_switched_by_edges_whatever_was_asked_for_before(path: Path) -> None:
    box, host = Mailbox(path, LAYOUT), RemoteHost(Mailbox(path, LAYOUT), VirtualClock(), 2)
    wanted = Setpoints([nan, nan])
    for output, on in [(2, True), (2, True), (0, False), (2, False), (1, True)]:
        wanted = replace(wanted, switches=wanted.switched(output, on))
        box.write_setpoints(wanted)
        assert host.request(0).switched == [(output, on)]
        assert host.request(0).switched == ()
    wanted = replace(wanted, switches=wanted.switched(0, True))
    box.write_setpoints(replace(wanted, switches=wanted.switched(3, True)))
    assert host.request(0).switched == [(0, True), (3, True)]


def test_rates_come_across_and_a_late_demand_counts_from_when_it_was_meant(path: Path) -> None:
    box, clock = Mailbox(path, LAYOUT), VirtualClock()
    host = RemoteHost(Mailbox(path, LAYOUT), clock, 2)
    box.write_setpoints(Setpoints([0.1, 0.2]))
    assert host.request(0)[5:7] == (None, None)
    meant = NS_PER_SECOND - NS_PER_SECOND // 50
    box.write_setpoints(
        Setpoints([0.1, 0.2], velocities=[1.0, 2.0], accelerations=[3.0, 4.0], asks=1, target_time=meant)
    )
    found = host.request(NS_PER_SECOND)
    assert (found.velocities, found.accelerations) == ([1.0, 2.0], [3.0, 4.0])
    assert found.since == pytest.approx(0.02)
    box.write_setpoints(
        Setpoints([0.1, 0.2], velocities=[1.0, 2.0], accelerations=[3.0, 4.0], asks=1, target_time=meant)
    )
    again = host.request(NS_PER_SECOND + NS_PER_SECOND // 100)
    assert again.age == 0.0
    assert again.since == pytest.approx(0.03), "to live is not to ask"
    box.write_setpoints(Setpoints([0.1, 0.2], velocities=[1.0, 2.0], asks=2, target_time=5))
    assert host.request(2 * NS_PER_SECOND).since == 0.0, "a clock of another kind is not believed"


def test_the_mailbox_of_those_who_were_killed_is_swept_away() -> None:
    used, left = Mailbox.create(LAYOUT), Mailbox.create(LAYOUT)
    box, gone = Mailbox(used, LAYOUT), Mailbox(left, LAYOUT)
    gone.close()
    remove_orphaned_files(MAILBOX_PREFIX)
    assert left.exists(), "it may be on its way to the loop"
    long_ago = time.time() - 2.0 * MIN_MAILBOX_AGE
    for path in (used, left):
        os.utime(path, (long_ago, long_ago))
    remove_orphaned_files(MAILBOX_PREFIX)
    assert not left.exists()
    assert used.exists(), "it is in use"
    box.close()
    box.close()
    used.unlink()
