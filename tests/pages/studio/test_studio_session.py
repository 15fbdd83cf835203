"""Results follow the newest edit, A stays what it was, and the process that simulates serves many designs in turn."""

import asyncio
import pickle
from collections.abc import Awaitable, Callable, Iterator
from multiprocessing import active_children
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.machine.loader import load
from layflat.pages.server.worker import ProcessWorker as Beside
from layflat.pages.studio.cloud import JointStep, StepCloud, Tolerances, simulate_cloud
from layflat.pages.studio.design import Design
from layflat.pages.studio.report import ReportContent, render_report
from layflat.pages.studio.session import StudioSession
from layflat.pages.studio.worker import StudioProcesses, open_design

pytestmark = pytest.mark.compiled
WIDTH = "joint.large.hose.width"


class InThread(Beside):
    """Does work in a thread, on copies, as another process does."""

    async def call(self, function: Any, *arguments: Any, limit: float, what: str, by: object = None) -> Any:  # noqa: ARG002
        return await asyncio.to_thread(function, *pickle.loads(pickle.dumps(arguments)))


class Immediate(StudioProcesses):
    """Simulates a few runs at once; a request that is overtaken has no result."""

    def __init__(self) -> None:
        super().__init__()
        self.helper = InThread("")
        self.newest: dict[int, int] = {}

    def overtake(self, tab: int, number: int) -> None:
        self.newest[tab] = number

    async def cloud(
        self, tab: int, number: int, machine: Machine, step: JointStep, tolerances: Tolerances
    ) -> StepCloud | LayflatError | None:
        self.overtake(tab, number)
        await asyncio.sleep(0.01)
        return simulate_cloud(machine, step, tolerances, runs=8) if number >= self.newest.get(tab, 0) else None


def followed(session: StudioSession, act: Callable[[], Awaitable[None]]) -> None:
    """Do something while a session follows."""

    async def run() -> None:
        task = asyncio.create_task(session.follow())
        await act()
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)

    asyncio.run(run())


async def current(session: StudioSession) -> None:
    """Wait until all results belong to the newest request."""

    def is_current() -> bool:
        shown, kept = session.shown, session.kept
        return (
            shown.figures_number == shown.cloud_number == session.number
            and (kept is None or kept.shown.cloud is not None)
        )  # fmt: skip

    for _ in range(1000):
        if is_current():
            return
        await asyncio.sleep(0.01)
    raise AssertionError("results do not come")


@pytest.fixture
def session(design: Design) -> StudioSession:
    return StudioSession(design, Immediate())


def test_results_belong_to_the_newest_edit(session: StudioSession) -> None:
    seen: list[tuple[str, bool]] = []
    session.listen(lambda what: seen.append((what, session.shown.cloud_number == session.number)))

    async def act() -> None:
        await current(session)
        first = session.shown.cloud
        for width in (170, 180, 190):
            session.design.edit(WIDTH, f"{width} mm")
            session.renew()
            assert session.shown.cloud_number < session.number
            await asyncio.sleep(0.0)
        await current(session)
        assert isinstance(first, StepCloud)
        assert isinstance(session.shown.cloud, StepCloud)
        assert not np.array_equal(first.angle, session.shown.cloud.angle)
        assert session.shown.cloud.angle[0] == pytest.approx(
            simulate_cloud(session.design.machine, session.step, runs=8).angle[0]
        )

    followed(session, act)
    assert ("cloud", True) in seen
    assert ("design", True) not in seen


@pytest.mark.parametrize("work", ["save", "reload"])
def test_an_edit_while_the_file_is_at_work_stays(tmp_path: Path, work: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('extends = "paper-arm"\nname = "mine"\n')
    session = StudioSession(open_design(str(path)), Immediate())
    session.design.edit(WIDTH, "150 mm")

    async def edit_meanwhile() -> None:
        task = asyncio.create_task(session.save(path) if work == "save" else session.reload())
        for width in ("140 mm", "130 mm"):
            await asyncio.sleep(0.0)
            session.design.edit(WIDTH, width)
        await task

    asyncio.run(edit_meanwhile())
    assert session.design.value(WIDTH) == pytest.approx(0.13)
    assert session.design.can_undo == (work == "save")  # what was edited before a reload can't be taken back
    assert not session.design.opened.changed_on_disk()
    if work == "save":
        assert session.design.opened.rewritten
        assert load(str(path)).joint["large"].hose.width == pytest.approx(0.15)


def test_a_is_kept_while_the_design_goes_on(session: StudioSession) -> None:
    async def act() -> None:
        await current(session)
        session.keep_as_a()
        session.design.edit(WIDTH, "200 mm")
        session.renew()
        await current(session)
        assert session.kept is not None
        assert isinstance(session.kept.shown.cloud, StepCloud)
        before = session.kept.shown.cloud
        session.show_joint("small")
        await current(session)
        assert isinstance(session.kept.shown.cloud, StepCloud)
        assert session.kept.shown.cloud.step.joint == "small"
        assert before.step.joint == "large"
        session.drop()
        assert session.kept is None

    followed(session, act)


def test_a_page_that_ends_late_takes_no_result_with_it(session: StudioSession) -> None:
    """A page that is loaded again follows before the one that it was has ended, whose request may be the newest."""

    async def act() -> None:
        for leaves in (0, 1):
            pages = [asyncio.create_task(session.follow()) for _ in range(2)]
            await current(session)
            session.design.edit(WIDTH, f"{180 + leaves} mm")
            session.renew()
            await asyncio.sleep(0.003)
            pages[leaves].cancel()
            await current(session)
            pages[1 - leaves].cancel()
            await asyncio.gather(*pages, return_exceptions=True)

    asyncio.run(act())


def test_a_report_needs_nothing_else(session: StudioSession) -> None:
    async def act() -> None:
        session.design.edit(WIDTH, "200 mm")
        session.keep_as_a()
        session.design.edit(WIDTH, "210 mm")
        session.renew()
        await current(session)

    followed(session, act)
    text = render_report(pickle.loads(pickle.dumps(ReportContent.from_session(session))))
    assert text.count("<figure") == 3
    assert "210 mm" in text
    assert "now less A" in text
    assert "5.5 kg is from before" in text or not session.stale
    for word in ('src="http', 'href="http', "url(http", "<script", "<link", "@import"):
        assert word not in text


@pytest.fixture(scope="module")
def worker() -> Iterator[StudioProcesses]:
    made = StudioProcesses()
    yield made
    made.end()


def test_another_process_simulates_the_same(worker: StudioProcesses, design: Design) -> None:
    async def ask(*given: Any) -> Any:
        return await worker.cloud(worker.tab(), 1, *given)

    step = JointStep("large", duration=0.5)
    found = asyncio.run(ask(design.machine, step, Tolerances()))
    here = simulate_cloud(design.machine, step)
    assert np.array_equal(found.angle, here.angle)
    assert found.quantities == here.quantities
    wrong = asyncio.run(ask(design.machine, JointStep("large", size=3.0), Tolerances()))
    assert "outside the working stroke" in str(wrong)


def test_what_is_overtaken_has_no_result_and_a_lost_process_begins_again(
    worker: StudioProcesses, design: Design
) -> None:
    step = JointStep("large", duration=0.2)

    async def both() -> tuple[Any, Any]:
        tab = worker.tab()
        first = asyncio.ensure_future(worker.cloud(tab, 1, design.machine, step, Tolerances()))
        await asyncio.sleep(0.0)
        worker.overtake(tab, 2)
        old = await first
        for process in active_children():
            process.kill()
            process.join()
        return old, await worker.cloud(tab, 3, design.machine, step, Tolerances())

    old, new = asyncio.run(both())
    assert old is None
    assert isinstance(new, StepCloud)


def test_a_law_that_fails_is_said_and_the_next_edit_goes_on(
    session: StudioSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def act() -> None:
        await current(session)
        with monkeypatch.context() as patch:
            patch.setattr("layflat.pages.studio.results.design_joint", lambda *_, **__: 1 / 0)
            session.design.edit(WIDTH, "200 mm")
            session.renew()
            for _ in range(1000):
                await asyncio.sleep(0.01)
                if session.findings and session.findings[0].rule == "results":
                    break
            assert "ZeroDivisionError" in session.findings[0].what
        session.design.edit(WIDTH, "210 mm")
        session.renew()
        await current(session)

    followed(session, act)
