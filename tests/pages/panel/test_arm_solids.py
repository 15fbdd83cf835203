"""Solids of a panel's arm are made while it rests, and by no process that hinders another."""

import asyncio
import os
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from layflat import extras
from layflat.errors import DesignError
from layflat.machine import load
from layflat.pages.panel import solids
from layflat.pages.panel.solids import ArmSolids
from layflat.rig.safety.faults import RigState

STARTED = Path("started")
SOLIDS: list[Any] = ["solid"]


def make_slowly(_machine: object, _budget: int) -> list[Any]:
    with STARTED.open("a") as file:
        file.write(f"{os.nice(0)}\n")
    time.sleep(1.0)
    return SOLIDS


def fail(_machine: object, _budget: int) -> list[Any]:
    raise DesignError("can't be made")


@pytest.fixture(autouse=True)
def workplace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(solids, "kept_solids", make_slowly)
    monkeypatch.setattr(extras, "available", lambda *_: True)


class Rig:
    """A rig that is not there, then in a state."""

    state: RigState | None = None

    def snapshot(self) -> Any:
        return None if self.state is None else SimpleNamespace(state=self.state)


def starts() -> list[str]:
    return STARTED.read_text().split() if STARTED.exists() else []


async def until_started(number: int) -> None:
    for _ in range(600):
        if len(starts()) >= number:
            return
        await asyncio.sleep(0.05)
    raise AssertionError(starts())


def test_a_move_ends_the_work_which_begins_again_at_rest() -> None:
    rig = Rig()
    arm = ArmSolids(load("paper-arm"), rig.snapshot)

    async def moved() -> None:
        pages = [asyncio.create_task(arm.await_solids()) for _ in range(2)]
        for state in (None, RigState.STARTING, RigState.MOVING):
            rig.state = state
            await asyncio.sleep(1.5)
            assert not starts()
        rig.state = RigState.OFF
        await until_started(1)
        rig.state = RigState.MOVING
        await asyncio.sleep(2.0)
        assert not any(page.done() for page in pages)
        rig.state = RigState.READY
        assert await asyncio.gather(*pages, arm.await_solids()) == 3 * [SOLIDS]

    asyncio.run(moved())
    assert starts() == ["19"] * 2


def test_an_arm_that_can_t_be_made_is_drawn_by_rods(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = Rig()
    rig.state = RigState.OFF
    monkeypatch.setattr(solids, "kept_solids", fail)
    assert asyncio.run(ArmSolids(load("paper-arm"), rig.snapshot).await_solids()) == []


def test_without_the_extra_a_line_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    arm = ArmSolids(load("paper-arm"), Rig().snapshot)
    assert not arm.hint
    monkeypatch.setattr(extras, "available", lambda extra: extra != "cad")
    assert "pip install 'layflat[cad]'" in arm.hint
    assert asyncio.run(arm.await_solids()) == []
    assert not starts()
