"""Firmware of the paper's arm for this computer, built once."""

from typing import Any

import pytest

from layflat.machine import load
from tests.export.firmware.controllers import Firmware


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return Firmware(load("paper-arm")).build(tmp_path_factory.mktemp("controller"))
