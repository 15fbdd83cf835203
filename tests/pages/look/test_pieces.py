"""Pages that are built at the same time take turns: one piece of one of them in a turn of the event loop."""

import asyncio
import time

from layflat.pages.look.pieces import TurnQueue

TASKS, PIECES, WORK = 30, 4, 0.004


def test_one_piece_in_a_turn_in_order() -> None:
    done: list[int] = []

    async def build(number: int, queue: TurnQueue) -> None:
        for _ in range(PIECES):
            await queue.wait()
            done.append(number)
            time.sleep(WORK)

    async def go() -> int:
        queue = TurnQueue()
        tasks = [asyncio.create_task(build(number, queue)) for number in range(TASKS)]
        tasks[3].cancel()
        most, before = 0, 0
        while not all(task.done() for task in tasks):
            await asyncio.sleep(0)
            most, before = max(most, len(done) - before), len(done)
        return most

    assert asyncio.run(go()) == 1
    assert done == [number for number in range(TASKS) if number != 3] * PIECES


def test_whose_page_goes_while_it_waits_holds_up_nobody() -> None:
    done: list[str] = []

    async def build(name: str, queue: TurnQueue) -> None:
        await queue.wait()
        done.append(name)

    async def go() -> None:
        queue = TurnQueue()
        first, second, third = (asyncio.create_task(build(name, queue)) for name in ("a", "b", "c"))
        await asyncio.sleep(0)
        first.cancel()
        second.cancel()
        await asyncio.wait_for(third, 1.0)
        await asyncio.wait_for(build("d", queue), 1.0)

    asyncio.run(go())
    assert done == ["c", "d"]
