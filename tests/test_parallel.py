"""What is done beside each other: in other processes, as far as they can be had."""

import os
from collections.abc import Iterator
from time import sleep

import pytest

from layflat.parallel import aside, processors


def numbers(count: int) -> Iterator[int]:
    """Yield some numbers, and the process that they come from."""
    yield from range(count)
    yield os.getpid()


def broken() -> Iterator[int]:
    """Yield a number, and fail."""
    yield 1
    raise ValueError


def endless() -> Iterator[int]:
    """Yield the process, and never end."""
    yield os.getpid()
    sleep(1e6)


needs_two = pytest.mark.skipif(processors() < 2, reason="needs two processors")


@needs_two
def test_another_process_gives_values_as_they_come() -> None:
    with aside("tests.test_parallel:numbers", 3) as values:
        *found, process = values
    assert found == [0, 1, 2]
    assert process != os.getpid()


@needs_two
def test_what_fails_there_ends_early_and_what_nobody_waits_for_is_killed(capfd: pytest.CaptureFixture[str]) -> None:
    with aside("tests.test_parallel:broken") as values:
        assert list(values) == [1]
    with aside("tests.test_parallel:nothing") as values:
        assert list(values) == []
    with aside("tests.test_parallel:endless") as values:
        process = next(values)
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)
    assert capfd.readouterr() == ("", "")


def test_with_one_processor_everything_is_left_to_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("layflat.parallel.processors", lambda: 1)
    with aside("tests.test_parallel:numbers", 3) as values:
        assert list(values) == []


def test_processors_are_counted_without_affinity(monkeypatch: pytest.MonkeyPatch) -> None:
    assert processors() >= 1
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    assert processors() == os.cpu_count()
