"""Work beside an event loop: results and errors come back, what takes too long or is cancelled ends."""

import asyncio
import time
from collections.abc import Iterator
from multiprocessing import get_context
from os import _exit, getpid
from typing import Any

import pytest

from layflat.errors import InputError, LayflatError
from layflat.pages.server.worker import ProcessWorker


@pytest.fixture
def worker() -> Iterator[ProcessWorker]:
    made = ProcessWorker("layflat-test")
    yield made
    made.end()


def refuse(value: int) -> int:
    raise InputError(f"{value} is too much", where="value", right="give less")


def call(worker: ProcessWorker, function: object, *arguments: object, limit: float = 30.0) -> object:
    return asyncio.run(worker.call(function, *arguments, limit=limit, what="the work"))  # type: ignore[arg-type]


def test_results_and_errors_come_back_from_one_process(worker: ProcessWorker) -> None:
    assert call(worker, sum, [1, 2, 3]) == 6
    pid = call(worker, getpid)
    assert pid not in (getpid(), None)
    with pytest.raises(InputError, match="value: 7 is too much; give less") as refused:
        call(worker, refuse, 7)
    assert refused.value.right == "give less"
    with pytest.raises(LayflatError, match=r"sum failed \(TypeError: "):
        call(worker, sum, 5)
    assert call(worker, getpid) == pid


def test_what_takes_too_long_ends_and_another_process_goes_on(worker: ProcessWorker) -> None:
    pid = call(worker, getpid)
    begun = time.monotonic()
    with pytest.raises(LayflatError, match=r"the work took longer than 0\.2 s and was ended"):
        call(worker, time.sleep, 60.0, limit=0.2)
    assert time.monotonic() - begun < 20.0
    assert call(worker, getpid) != pid


def test_what_is_cancelled_ends_and_another_process_goes_on(worker: ProcessWorker) -> None:
    call(worker, getpid)

    async def cancelled() -> None:
        work = asyncio.ensure_future(worker.call(time.sleep, 60.0, limit=50.0, what="the work", by=worker))
        await asyncio.sleep(0.2)
        worker.cancel(worker)
        await work

    with pytest.raises(LayflatError, match="the work was cancelled"):
        asyncio.run(cancelled())
    assert call(worker, sum, [1]) == 1


def test_a_process_that_dies_is_told_and_begun_again(worker: ProcessWorker) -> None:
    with pytest.raises(LayflatError, match="the work has ended with its process: try again"):
        call(worker, _exit, 3)
    assert call(worker, sum, [1]) == 1


def test_a_worker_that_was_ended_says_so() -> None:
    worker = ProcessWorker("layflat-test")
    worker.end()
    with pytest.raises(LayflatError, match="being closed"):
        call(worker, sum, [1])


def test_who_cancels_ends_what_it_asked_for_and_nothing_else(worker: ProcessWorker) -> None:
    async def cancelled() -> list[object]:
        mine, yours = object(), object()

        def sleeping(seconds: float, by: object) -> "asyncio.Future[object]":
            return asyncio.ensure_future(worker.call(time.sleep, seconds, limit=50.0, what="the work", by=by))

        await worker.call(getpid, limit=30.0, what="the beginning")
        calls = [sleeping(0.3, yours), sleeping(60.0, mine), sleeping(60.0, mine), sleeping(0.0, yours)]
        await asyncio.sleep(0.1)
        worker.cancel(mine)  # while they stand in line
        await calls[0]
        calls.append(sleeping(60.0, mine))
        last = sleeping(0.0, yours)
        await asyncio.sleep(0.2)
        worker.cancel(yours)  # which stands in line behind what goes on
        worker.cancel(mine)
        return await asyncio.gather(*calls, last, return_exceptions=True)

    found = asyncio.run(cancelled())
    assert [str(one) for one in (found[1], found[2], *found[4:])] == ["the work was cancelled"] * 4
    assert found[0] is None
    assert found[3] is None


kept: list[Any] = []


def keep(shared: Any) -> None:
    kept.append(shared)


def kept_value() -> object:
    return kept[0].value


def test_a_process_has_what_is_shared_with_it_from_its_beginning() -> None:
    number = get_context("spawn").Value("d", 2.5)
    worker = ProcessWorker("layflat-test", first=keep, shared=(number,))
    try:
        assert call(worker, kept_value) == 2.5
        number.value = 3.5
        assert call(worker, kept_value) == 3.5
    finally:
        worker.end()


def test_a_worker_ends_while_a_call_that_is_larger_than_a_pipe_waits(worker: ProcessWorker) -> None:
    async def ended() -> None:
        first = asyncio.ensure_future(worker.call(time.sleep, 60.0, limit=50.0, what="the work"))
        second = asyncio.ensure_future(worker.call(len, bytes(10**7), limit=50.0, what="the work"))
        await asyncio.sleep(1.0)
        worker.end()
        found = await asyncio.gather(first, second, return_exceptions=True)
        assert all(isinstance(one, (LayflatError, asyncio.CancelledError)) for one in found), found

    begun = time.monotonic()
    asyncio.run(ended())
    assert time.monotonic() - begun < 20.0


def test_calls_of_who_is_gone_are_not_made_and_the_one_that_goes_on_is(worker: ProcessWorker) -> None:
    async def left() -> list[object]:
        await worker.call(getpid, limit=30.0, what="the beginning")
        mine = [worker.call(time.sleep, seconds, limit=50.0, what="the work", by="me") for seconds in (0.3, 60.0, 60.0)]
        calls = [asyncio.ensure_future(one) for one in mine]
        await asyncio.sleep(0.1)
        worker.forget("me")
        return await asyncio.gather(*calls, return_exceptions=True)

    first, *others = asyncio.run(left())
    assert first is None
    assert [str(one) for one in others] == ["the work was cancelled"] * 2
