"""The ring: what goes in comes out, in order, whoever dies."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.errors import InputError
from layflat.rig.recorder.ring import ALIVE_TIMEOUT, MAX_EVENT_BYTES, Event, EventLevel, RecorderState, Ring
from layflat.rig.system import RING_PREFIX, lock_file, remove_orphaned_files
from tests.rig.recorder.rigrows import LAYOUT, rows


@pytest.fixture
def ring() -> Iterator[Ring]:
    made = Ring.create(LAYOUT.width, rows=8, events=4)
    yield made
    made.remove()
    made.close()


@given(st.lists(st.integers(0, 12), max_size=12))
def test_rows_come_out_as_they_went_in_and_those_without_room_are_counted(pushes: list[int]) -> None:
    ring = Ring.create(LAYOUT.width, rows=8)
    made, taken, expected, k = rows(200), [], [], 0
    for count in pushes:
        for i in range(count):
            assert ring.push(made[k]) == (i < 8)
            expected += [k] if i < 8 else []
            k += 1
        taken.append(ring.drain())
    assert np.array_equal(np.concatenate([*taken, made[:0]]), made[expected])
    assert ring.head.rows.dropped == k - len(expected)
    ring.remove()
    ring.close()


def test_both_sides_see_the_same(ring: Ring) -> None:
    other = Ring.attach(ring.path)
    assert other.head.width == LAYOUT.width
    ring.push(rows(1)[0])
    ring.put_event(Event(0.5, EventLevel.WARN, "supply lost"))
    ring.end()
    assert np.array_equal(other.drain(), rows(1))
    assert other.drain_events() == [Event(0.5, EventLevel.WARN, "supply lost")]
    assert other.head.ended
    other.beat(RecorderState.STUCK)
    assert ring.recorder is RecorderState.STUCK
    other.close()


def test_a_recorder_is_alive_for_a_second_after_its_last_sign(ring: Ring) -> None:
    assert not ring.is_recorder_alive()
    ring.beat(RecorderState.RECORDING)
    assert ring.is_recorder_alive()
    ring.head.recorder_beat -= ALIVE_TIMEOUT
    assert not ring.is_recorder_alive()
    assert not ring.is_loop_alive()
    ring.push(rows(1)[0])
    assert ring.is_loop_alive()
    ring.head.loop_beat -= ALIVE_TIMEOUT
    assert not ring.is_loop_alive()


def test_events_without_room_are_counted_and_long_ones_cut_between_characters(ring: Ring) -> None:
    text = "x" * (MAX_EVENT_BYTES - 1) + "é and more"
    assert [ring.put_event(Event(0.0, EventLevel.INFO, text)) for _ in range(5)] == [True] * 4 + [False]
    assert ring.head.events.dropped == 1
    assert {event.text for event in ring.drain_events()} == {"x" * (MAX_EVENT_BYTES - 1)}


def test_memory_outlives_those_who_join(ring: Ring) -> None:
    """Python's own shared memory is removed by the resource tracker of any process that dies."""
    join = (
        "import sys, time; from pathlib import Path; from layflat.rig.recorder.ring import Ring\n"
        "ring = Ring.attach(Path(sys.argv[1])); ring.put_event(ring.drain_events()[0]); "
        "print('in', flush=True); time.sleep(float(sys.argv[2]))"
    )
    for wait, end in (("0", 0), ("60", -signal.SIGKILL)):
        ring.put_event(Event(1.0, EventLevel.INFO, "hello"))
        with subprocess.Popen([sys.executable, "-c", join, str(ring.path), wait], stdout=subprocess.PIPE) as child:
            assert child.stdout is not None
            assert child.stdout.readline() == b"in\n"
            if end:
                child.kill()
            assert child.wait() == end
        assert ring.path.exists()
        other = Ring.attach(ring.path)
        assert other.drain_events() == [Event(1.0, EventLevel.INFO, "hello")]
        other.close()


def test_what_nobody_uses_is_swept_away_and_what_is_used_stays() -> None:
    used = Ring.create(LAYOUT.width)
    left = Ring.create(LAYOUT.width)
    path = left.path
    left.close()
    remove_orphaned_files(RING_PREFIX)
    assert not path.exists()
    assert used.path.exists()
    used.remove()
    used.remove()
    used.close()


def test_only_a_ring_can_be_joined(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="No such file"):
        Ring.attach(tmp_path / "none")
    (tmp_path / "other").write_bytes(bytes(4096))
    with pytest.raises(InputError, match="not a ring of this version"):
        Ring.attach(tmp_path / "other")


def test_a_push_is_short() -> None:
    ring, row = Ring.create(LAYOUT.width), rows(1)[0]
    best = 1.0
    for _ in range(20):
        since = time.perf_counter()
        for _ in range(200):
            ring.push(row)
        best = min(best, (time.perf_counter() - since) / 200)
    ring.remove()
    ring.close()
    assert best < 20e-6  # 2 us where nothing else runs


def test_a_ring_that_another_process_holds_alone_is_refused(tmp_path: Path) -> None:
    (path := tmp_path / "ring").touch()
    with path.open("r+b") as other:
        lock_file(other.fileno())
        with pytest.raises(InputError, match="is locked by another process; give the ring of a loop that runs"):
            Ring.attach(path)
