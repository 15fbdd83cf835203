import os
import signal
import socket
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from layflat.errors import InputError
from layflat.study import Study, read_study, run_study, runs
from layflat.study.runs import _chunk_rows, simulate_rows_on_worker, software_versions
from tests.study.studies import SMALL, written

distributed = pytest.importorskip("distributed")


@pytest.fixture
def study(tmp_path: Path) -> Study:
    return read_study(written(tmp_path, SMALL))


@pytest.fixture
def client() -> Iterator[Any]:
    """A client of its own beside two worker processes of one thread each."""
    workers = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs="CRITICAL"
    )
    with workers, distributed.Client(workers, set_as_default=False) as one:
        yield one


def die_in_a_chunk(when: Path) -> None:
    """On a worker: begin the next chunk, and be killed in it as soon as a file is there or the cluster closes."""

    def killed(*words: object, **options: object) -> None:
        while not when.exists() and distributed.get_worker().status == distributed.Status.running:
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGKILL)

    runs.simulate_rows = killed


def test_a_lost_worker_changes_nothing(tmp_path: Path, study: Study, client: Any) -> None:
    here = run_study(study, tmp_path / "here", chunk=2)
    doomed, other = client.scheduler_info()["workers"]
    client.run(die_in_a_chunk, tmp_path / "now", workers=[doomed])
    told = []

    def half_way(done: int, total: int) -> None:
        told.append(done)
        if done == total // 2:
            (tmp_path / "now").touch()

    there = run_study(study, tmp_path / "there", chunk=2, scheduler=client.scheduler.address, progress=half_way)
    workers = client.scheduler_info()["workers"]
    assert doomed not in workers
    assert other in workers
    assert told == list(range(0, 26, 2))
    assert there.read_bytes() == here.read_bytes()


def test_a_study_goes_on_here_when_its_cluster_is_lost(
    tmp_path: Path, study: Study, client: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runs, "SCHEDULER_TIMEOUT", 1.0)

    client.run(die_in_a_chunk, tmp_path / "never", workers=list(client.scheduler_info()["workers"])[:1])

    def lose(done: int, total: int) -> None:
        if done == 2:
            client.shutdown()

    with pytest.raises(InputError, match=r"the cluster failed \(.*; the same command goes on"):
        run_study(study, tmp_path / "there", chunk=1, scheduler=client.scheduler.address, progress=lose)
    there = run_study(study, tmp_path / "there", chunk=1)
    assert there.read_bytes() == run_study(study, tmp_path / "here", chunk=1).read_bytes()


def test_a_worker_with_other_laws_is_refused(study: Study) -> None:
    (_, runs), *_ = _chunk_rows(study, 2, {0})
    with pytest.raises(InputError, match=r"a worker has laws \w+, not others; install the same on all workers"):
        simulate_rows_on_worker(study, runs, {**software_versions(study), "laws": "others"})
    assert simulate_rows_on_worker(study, runs, software_versions(study)).num_rows == 2


def test_no_cluster_at_the_address(tmp_path: Path, study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    # It is asked twice: who it is, and by the client.
    assert 2 * runs.SCHEDULER_TIMEOUT < 10.0
    monkeypatch.setattr(runs, "SCHEDULER_TIMEOUT", 1.0)
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        taken = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        for address in (taken, "nonsense", "foo://127.0.0.1:1"):
            began = time.monotonic()
            with pytest.raises(InputError, match=f"scheduler {address}: no Dask scheduler answers; give the address"):
                run_study(study, tmp_path / "out", scheduler=address)
            assert time.monotonic() - began < 4.0
    assert not list((tmp_path / "out").rglob("*.parquet"))


def test_without_dask_it_says_how_to_get_it(tmp_path: Path, study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"distributed, not installed.*pip install 'layflat\[cluster\]'"):
        run_study(study, tmp_path / "out", scheduler="tcp://127.0.0.1:8786")
