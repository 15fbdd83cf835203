"""Work beside an event loop: results and errors come back, what takes too long or is cancelled ends."""

import asyncio
import time
from collections.abc import Iterator
from os import _exit, getpid

import pytest

from layflat.errors import InputError, LayflatError
from layflat.pages.server.worker import Worker


@pytest.fixture
def worker() -> Iterator[Worker]:
    made = Worker("layflat-test")
    yield made
    made.end()


def refuse(value: int) -> int:
    raise InputError(f"{value} is too much", where="value", right="give less")


def call(worker: Worker, function: object, *arguments: object, limit: float = 30.0) -> object:
    return asyncio.run(worker.call(function, *arguments, limit=limit, what="the work"))  # type: ignore[arg-type]


def test_results_and_errors_come_back_from_one_process(worker: Worker) -> None:
    assert call(worker, sum, [1, 2, 3]) == 6
    pid = call(worker, getpid)
    assert pid not in (getpid(), None)
    with pytest.raises(InputError, match="value: 7 is too much; give less") as refused:
        call(worker, refuse, 7)
    assert refused.value.right == "give less"
    with pytest.raises(LayflatError, match=r"sum failed \(TypeError: "):
        call(worker, sum, 5)
    assert call(worker, getpid) == pid


def test_what_takes_too_long_ends_and_another_process_goes_on(worker: Worker) -> None:
    pid = call(worker, getpid)
    begun = time.monotonic()
    with pytest.raises(LayflatError, match=r"the work took longer than 0\.2 s and was ended"):
        call(worker, time.sleep, 60.0, limit=0.2)
    assert time.monotonic() - begun < 20.0
    assert call(worker, getpid) != pid


def test_what_is_cancelled_ends_and_another_process_goes_on(worker: Worker) -> None:
    call(worker, getpid)

    async def cancelled() -> None:
        work = asyncio.ensure_future(worker.call(time.sleep, 60.0, limit=50.0, what="the work"))
        await asyncio.sleep(0.2)
        worker.cancel()
        await work

    with pytest.raises(LayflatError, match="the work was cancelled"):
        asyncio.run(cancelled())
    assert call(worker, sum, [1]) == 1


def test_a_process_that_dies_is_told_and_begun_again(worker: Worker) -> None:
    with pytest.raises(LayflatError, match="the work was cancelled"):
        call(worker, _exit, 3)
    assert call(worker, sum, [1]) == 1


def test_a_worker_that_was_ended_says_so() -> None:
    worker = Worker("layflat-test")
    worker.end()
    with pytest.raises(LayflatError, match="being closed"):
        call(worker, sum, [1])
