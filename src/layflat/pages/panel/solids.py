"""Solids of a panel's arm, made by a process that works only while the arm rests."""

import asyncio
from collections.abc import Callable

from layflat import extras
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.pages.server.worker import ProcessWorker
from layflat.parallel import lower_priority
from layflat.rig.safety.faults import RigState
from layflat.rig.session import RigSnapshot
from layflat.solids.kept import kept_solids
from layflat.solids.moving import MovingSolids

MAX_TRIANGLES = 8000  # triangles of an arm: in software drawn as fast as an arm of rods, some 35 ms a picture
SOLIDS_TIMEOUT = 300.0  # of making the solids, s
LOOK_PERIOD = 0.1  # of looks at the arm, s
LEAST_REST = 1.0  # of the arm before work begins, s
MOVING_STATES = {RigState.STARTING, RigState.MOVING}
INSTALL_HINT = "Drawn by rods; by solids with pip install 'layflat[cad]'."


class ArmSolids:
    """Solids of an arm, made once for all pages.

    Args:
        machine: machine of the arm.
        snapshot: returns the rig's last cycle, None while there is none.
    """

    def __init__(self, machine: Machine, snapshot: Callable[[], RigSnapshot | None]) -> None:
        """Prepare the process, which starts with the first page."""
        self._machine, self._snapshot = machine, snapshot
        self._worker = ProcessWorker("layflat-panel-solids", first=lower_priority)
        self._making: asyncio.Task[list[MovingSolids]] | None = None

    @property
    def hint(self) -> str:
        """Hint at what to install; empty where it is installed."""
        return "" if extras.available("cad") else INSTALL_HINT

    async def await_solids(self) -> list[MovingSolids]:
        """Wait for the solids, and return them; none where they can't be made."""
        if self._making is None:
            self._making = asyncio.create_task(self._make())
        return await asyncio.shield(self._making)

    async def rest(self) -> None:
        """Wait until the rig is connected and the arm has rested for `LEAST_REST`."""
        looks = 0
        while looks * LOOK_PERIOD < LEAST_REST:
            await asyncio.sleep(LOOK_PERIOD)
            looks = looks + 1 if self._rests else 0

    def end(self) -> None:
        """End the process."""
        self._worker.end()

    @property
    def _rests(self) -> bool:
        shot = self._snapshot()
        return shot is not None and shot.state not in MOVING_STATES

    async def _make(self) -> list[MovingSolids]:
        """Make the solids while the arm rests; a move ends the work, which begins again after it."""
        try:
            while extras.available("cad"):
                await self.rest()
                call, moved = asyncio.ensure_future(self._request()), False
                while not call.done():
                    await asyncio.wait([call], timeout=LOOK_PERIOD)
                    if not call.done() and not self._rests:
                        self._worker.cancel(self)
                        moved = True
                if call.exception() is None or not moved:
                    return call.result()
        except LayflatError:
            pass  # they are a help, without which the arm is drawn by rods
        finally:
            self._worker.end()
        return []

    async def _request(self) -> list[MovingSolids]:
        what = "the making of solids"
        return await self._worker.call(
            kept_solids, self._machine, MAX_TRIANGLES, limit=SOLIDS_TIMEOUT, what=what, by=self
        )
