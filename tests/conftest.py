import gc
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from layflat.registers import interpreted
from tests.programs import missing_program_lines, skip_without

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as there are tests on all cores, threads would wait for each other

for variable in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "MAKEOVERRIDES"):
    os.environ.pop(variable, None)  # what a test makes prints the same where make runs the tests

USUAL_GC_THRESHOLDS = gc.get_threshold()  # before any command

settings.register_profile("layflat", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("layflat")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "compiled: far too slow without the JIT")
    signal.signal(signal.SIGINT, signal.default_int_handler)  # what runs in the background hands on that it is ignored


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if not interpreted():
        return
    for item in items:
        if "compiled" in item.keywords:
            item.add_marker(pytest.mark.skip(reason="far too slow without the JIT"))


def pytest_collection_finish() -> None:
    """Let the collector never look again at what the tests' modules hold, half a gigabyte that stays to the end."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def usual_garbage_collection() -> None:
    """Begin each test as Python begins: commands of tests before it leave the collector off, or at work more rarely."""
    gc.set_threshold(*USUAL_GC_THRESHOLDS)
    gc.enable()


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> Iterator[None]:
    """Say below all else which programs are missing, how many tests were left out for want of each, how to get it."""
    yield
    for line in missing_program_lines(terminalreporter.stats.get("skipped", [])):
        terminalreporter.write_line(line, yellow=True)


@pytest.fixture(scope="session", autouse=True)
def records_of_outputs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep records of what commands wrote apart from the user's."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LAYFLAT_STATE_DIR", str(tmp_path_factory.mktemp("state")))
        yield


@pytest.fixture(scope="session")
def opengl() -> None:
    """OpenGL without a screen; tests that draw are left out where there is none."""
    pytest.importorskip("mujoco")
    from layflat.bridge.view.picture import gl_context
    from layflat.errors import NoDrawingError

    try:
        gl_context(16, 16).free()
    except NoDrawingError:
        skip_without("OpenGL")


@pytest.fixture(scope="session")
def measured_data() -> Path:
    """Measurements that are not part of the package."""
    folder = Path(__file__).parents[2] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"needs the measured data in {folder}")
    return folder
