"""A check in a process of its own ends in peace."""

import atexit
import time

import pytest

from layflat.errors import InputError, LayflatError
from layflat.machine import load
from layflat.rig.check import check_in_subprocess
from layflat.rig.driver import Driver

SLOW = 0.3  # that Python takes to end, s


def nobody_there() -> Driver:
    atexit.register(time.sleep, SLOW)
    raise InputError("nobody is there", where="driver", right="switch it on")


def test_what_was_found_is_told_without_the_noise_of_an_end_broken_off(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(LayflatError, match="nobody is there"):
        check_in_subprocess(load("paper-arm"), nobody_there, air=False, tell=str)
    assert capfd.readouterr().err == ""
