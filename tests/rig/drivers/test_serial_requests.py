"""The serial driver with a device that runs the law itself, of which frames are put together by hand."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from layflat.rig import frames
from layflat.rig.driver import DriverError, LinkError, RigCommand
from layflat.rig.drivers import create_driver
from layflat.rig.drivers.serial import SerialDriver
from layflat.rig.safety.requests import DeviceRequest, settings_digest
from layflat.rig.wire import LAW_VERSION, Identity, WireError
from tests.rig.drivers.test_serial_bytes import HASTY, Terminal
from tests.rig.statuses import REQUESTS, status

DIGEST = settings_digest(HASTY)
IDENTITY = Identity.for_machine(HASTY)._replace(
    version=LAW_VERSION, centres_after=DIGEST >> 16, dumps_after=DIGEST & 0xFFFF
)


class LawDevice(Terminal):
    """Device at a pseudo-terminal; it keeps requests and answers with parts of a status."""

    def __init__(self) -> None:
        super().__init__()
        self.reply = self.answer
        self.identity = IDENTITY
        self.parts: tuple[int, ...] = (0, 1, 2)

    def answer(self, kind: int, sequence: int) -> bytes:
        if kind == frames.IDENTIFY_FRAME:
            return frames.encode(frames.IDENTITY_FRAME, sequence, frames.pack_words(self.identity.words()))
        assert kind == frames.REQUEST_FRAME
        kinds = frames.STATUS_FRAME, frames.SIGNALS_FRAME, frames.SIGNALS_FRAME
        parts = REQUESTS.status_bytes(status())
        return b"".join(frames.encode(kinds[i], sequence, parts[i]) for i in self.parts)


@pytest.fixture
def device() -> Iterator[LawDevice]:
    running = LawDevice()
    yield running
    running.close()


@pytest.fixture
def driver(device: LawDevice) -> Iterator[SerialDriver]:
    made = create_driver(f"serial://{device.path}", HASTY)
    assert isinstance(made, SerialDriver)
    made.configure().check(HASTY)
    made.activate()
    yield made
    made.finalize()


def test_it_recognises_the_device_and_returns_its_status(driver: SerialDriver) -> None:
    assert driver.runs_law
    driver.request(DeviceRequest([0.1, 0.2], [0.0] * 2, [0.0] * 2, (1, 0, 0, 0)))
    reading = driver.read()
    assert driver.status is not None
    np.testing.assert_array_equal(driver.status.signals, status().signals)
    np.testing.assert_array_equal(reading.angles, status().reading.angles)


@pytest.mark.parametrize(
    ("parts", "kind"),
    [((), "lost"), ((0, 1), "lost"), ((0, 2, 1), "crc"), ((1, 2), "sequence"), ((0, 0, 1), "sequence")],
)
def test_a_status_of_which_a_part_is_missing_is_a_lost_reply(
    device: LawDevice, driver: SerialDriver, parts: tuple[int, ...], kind: str
) -> None:
    device.parts = parts
    with pytest.raises(LinkError) as error:
        driver.read()
    assert error.value.kind == kind
    device.parts = (0, 1, 2)
    driver.read()


def test_voltages_are_refused(driver: SerialDriver) -> None:
    with pytest.raises(DriverError, match="runs its control law itself, and obeys no voltages"):
        driver.write(RigCommand(np.array([5.0, 5.0]), air=True))


def test_a_device_of_another_machine_is_refused_in_one_line(device: LawDevice) -> None:
    device.identity = IDENTITY._replace(dumps_after=IDENTITY.dumps_after ^ 1)
    with pytest.raises(DriverError) as error:
        create_driver(f"serial://{device.path}", HASTY).configure()
    assert "a control law that was exported from another machine than 'paper-arm'; give the description" in str(
        error.value
    )
    assert "\n" not in str(error.value)
    device.identity = IDENTITY._replace(joints=3)
    with pytest.raises(DriverError, match=r"the rig has 3 joint\(s\), the machine 'paper-arm' 2"):
        create_driver(f"serial://{device.path}", HASTY).configure()


def test_hosts_that_know_no_requests_refuse_it() -> None:
    with pytest.raises(WireError, match="the rig speaks version 2 of the protocol, layflat version 1"):
        Identity.from_words(IDENTITY.words())
