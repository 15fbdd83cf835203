import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.programs import INSTALL_ADVICE

NEEDY = """\
import pytest
from tests.programs import missing_reason, skip_without

@pytest.fixture(scope="module")
def browser():
    skip_without("chromium")

@pytest.mark.parametrize("number", range(3))
def test_of_pages(number, browser):
    pass

@pytest.mark.skipif(True, reason=missing_reason("MicroPython"))
def test_of_firmware():
    pass

@pytest.mark.usefixtures("opengl")
def test_of_pictures():
    pass

def test_of_another_reason():
    pytest.skip("not today")
"""


@pytest.mark.parametrize("options", [[], ["-n", "1"]], ids=["alone", "xdist"])
def test_what_was_left_out_is_told_at_the_end_with_how_to_get_it(options: list[str], tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    (tmp_path / "test_needy.py").write_text(NEEDY, encoding="utf-8")
    paths = os.pathsep.join([str(Path(__file__).parents[1]), *sys.path])
    environment = os.environ | {"PYTHONPATH": paths, "MUJOCO_GL": "disable"}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-rs", "-p", "tests.conftest", *options]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-4:-1] == [
        f"1 test left out: no OpenGL; {INSTALL_ADVICE['OpenGL']}",
        f"3 tests left out: no chromium; {INSTALL_ADVICE['chromium']}",
        f"1 test left out: no MicroPython; {INSTALL_ADVICE['MicroPython']}",
    ]
