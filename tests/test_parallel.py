"""What is done beside each other: in other processes, as far as they can be had."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep

import pytest

from layflat.parallel import generate_in_process, process_pool, processors


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


def nap(begun: Path) -> None:
    """Tell that work has begun, go on with it for long, and tell how it ended."""
    begun.touch()
    try:
        for _ in range(600):
            sleep(0.1)
    except KeyboardInterrupt:
        begun.with_suffix(".interrupted").touch()
        raise


needs_two = pytest.mark.skipif(processors() < 2, reason="needs two processors")


@needs_two
def test_another_process_gives_values_as_they_come() -> None:
    with generate_in_process("tests.test_parallel:numbers", 3) as values:
        *found, process = values
    assert found == [0, 1, 2]
    assert process != os.getpid()


@needs_two
def test_what_fails_there_ends_early_and_what_nobody_waits_for_is_killed(capfd: pytest.CaptureFixture[str]) -> None:
    with generate_in_process("tests.test_parallel:broken") as values:
        assert list(values) == [1]
    with generate_in_process("tests.test_parallel:nothing") as values:
        assert list(values) == []
    with generate_in_process("tests.test_parallel:endless") as values:
        process = next(values)
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)
    assert capfd.readouterr() == ("", "")


def blocked() -> Iterator[list[int]]:
    """Yield the signals that are blocked."""
    yield [int(one) for one in signal.pthread_sigmask(signal.SIG_BLOCK, ())]


@needs_two
def test_the_first_process_of_a_program_is_out_of_reach_of_the_terminal() -> None:
    program = """
from layflat.parallel import FROM_TERMINAL, generate_in_process
with generate_in_process("tests.test_parallel:blocked") as values:
    assert set(FROM_TERMINAL) <= set(next(values))
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_with_one_processor_everything_is_left_to_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("layflat.parallel.processors", lambda: 1)
    with generate_in_process("tests.test_parallel:numbers", 3) as values:
        assert list(values) == []


def test_processors_are_counted_without_affinity(monkeypatch: pytest.MonkeyPatch) -> None:
    assert processors() >= 1
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    assert processors() == os.cpu_count()


def test_whoever_gives_up_ends_work_that_goes_on_and_begins_no_more(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    begun, before = [tmp_path / f"job-{i}" for i in range(4)], monotonic()
    with suppress(KeyboardInterrupt), process_pool(1) as submit:
        jobs = [submit(nap, path) for path in begun]
        while not begun[0].exists():
            sleep(0.01)
        raise KeyboardInterrupt
    assert monotonic() - before < 30.0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["job-0", "job-0.interrupted"]
    assert all(job.done() for job in jobs)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("ended", range(500, 1000, 100))
def test_a_pool_of_short_work_ends_with_an_error(ended: int) -> None:
    """Its end comes as a signal at any line of a worker, mostly between one piece of work and the next."""
    with suppress(ZeroDivisionError), process_pool(2) as submit:
        jobs = [submit(abs, number) for number in range(3000)]
        assert jobs[ended].result() == ended
        raise ZeroDivisionError
    assert all(job.done() for job in jobs)


@pytest.mark.skipif(os.name != "posix", reason="needs groups of processes")
def test_ctrl_c_at_a_terminal_does_not_reach_a_pool() -> None:
    with process_pool(1) as submit:
        process = submit(os.getpid).result()
        job = submit(sleep, 0.5)
        os.kill(process, signal.SIGINT)
        assert job.result() is None
        assert submit(os.getpid).result() == process
