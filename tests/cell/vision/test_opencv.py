from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from layflat.cell.vision import check_picture
from layflat.errors import InputError


def test_without_opencv_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(InputError, match=r"not installed; install it: pip install 'layflat\[cell\]'"):
        check_picture(np.full((40, 40, 3), 128, np.uint8))


def test_vision_is_imported_without_opencv() -> None:
    code = "import sys; sys.modules['cv2'] = None; import layflat.cell.vision"
    subprocess.run([sys.executable, "-c", code], check=True)
