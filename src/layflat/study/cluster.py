"""A study's chunks on a Dask cluster; what a lost worker had under way, another one does again."""

import asyncio
import logging
from collections.abc import Iterator
from itertools import islice
from typing import TYPE_CHECKING, Any

from layflat.errors import InputError, LayflatError
from layflat.extras import module
from layflat.study.chunks import Work, made_with, measured_there
from layflat.study.study import Study

if TYPE_CHECKING:
    import pyarrow

PATIENCE = 4.0  # a scheduler has to answer within, s
AHEAD = 64  # chunks that wait at the scheduler, beside two for every thread: new workers find work at once


def on_cluster(study: Study, work: Work, scheduler: str) -> "Iterator[tuple[int, pyarrow.Table]]":
    """Yield chunks of a study as they get done, in any order.

    Raises:
        InputError: no scheduler answers, dask is not installed, or a chunk can't be done there.
    """
    where = f"--scheduler {scheduler}"
    client = _client(scheduler, where)
    try:
        yield from _done(client, study, work)
    except LayflatError:
        raise
    except Exception as error:  # whatever a cluster may raise
        what = f"the cluster failed ({type(error).__name__}: {''.join(str(error).splitlines()[:1])})"
        raise InputError(what, where=where, right="the same command goes on") from error
    finally:
        client.close()


def _done(client: Any, study: Study, work: Work) -> "Iterator[tuple[int, pyarrow.Table]]":
    from distributed import as_completed  # noqa: PLC0415

    waiting, numbers, own = iter(work), {}, made_with(study)

    def submit(count: int) -> list[Any]:
        futures = []
        for number, runs in islice(waiting, count):
            future = client.submit(measured_there, study, runs, own, pure=False)
            numbers[future.key] = number
            futures.append(future)
        return futures

    ahead = AHEAD + 2 * sum(client.nthreads().values())
    running = as_completed(submit(ahead), loop=client.loop, with_results=True)
    for future, table in running:
        if isinstance(table, BaseException):  # the scheduler is lost
            raise table
        for following in submit(1):
            running.add(following)
        yield numbers.pop(future.key), table


def _client(scheduler: str, where: str) -> Any:
    client = module("cluster", "distributed", where=where).Client
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what fails is told in one line, by us
    try:
        asyncio.run(asyncio.wait_for(_identity(scheduler), PATIENCE))
        return client(scheduler, timeout=PATIENCE, set_as_default=False)
    except Exception:  # of many libraries, depending on what else answers there
        right = "give the address that `dask scheduler` prints, such as tcp://10.0.0.1:8786"
        raise InputError("no Dask scheduler answers", where=where, right=right) from None


async def _identity(scheduler: str) -> None:
    """Ask a scheduler who it is: a client that finds none can't be closed without another long wait."""
    from distributed import Security  # noqa: PLC0415
    from distributed.core import rpc  # noqa: PLC0415

    security = Security().get_connection_args("client")
    async with rpc(scheduler, connection_args=security, timeout=PATIENCE) as remote:
        await remote.identity()
