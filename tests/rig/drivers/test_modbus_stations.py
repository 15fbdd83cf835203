"""Stations of other makes: exceptions, other registers and other numbers are told by name, with what helps."""

from __future__ import annotations

import struct
from collections.abc import Iterator

import numpy as np
import pytest

from layflat.rig.check import check_rig
from layflat.rig.clock import MonotonicClock
from layflat.rig.driver import DriverError, LinkError, RigCommand
from layflat.rig.drivers import create_driver
from layflat.rig.drivers.modbus import EXCEPTION_TEXTS, ModbusDriver, describe_missing_reply
from layflat.rig.open_loop import CheckResult
from layflat.rig.wire import IDENTITY_MAGIC, Identity
from tests.rig.devices import ARM, WIRE, patient
from tests.rig.stations import READING, Reply, Server, good

PATIENT = patient(ARM, 0.2)
WORDS = Identity.for_machine(ARM).words()


def refused(code: int, *functions: int) -> Reply:
    """A station that refuses functions with an exception."""

    def reply(request: bytes) -> bytes:
        return exception(request, code) if request[7] in functions else answered(request)

    return reply


def exception(request: bytes, code: int) -> bytes:
    return request[:4] + struct.pack(">HBBB", 3, request[6], request[7] | 0x80, code)


def answered(request: bytes) -> bytes:
    """The right reply to functions 3, 16 and 23; readings carry the number of the last command."""
    function, at = request[7], struct.unpack_from(">H", request, 8)[0]
    if function == 16:
        answered.number = struct.unpack_from(">H", request, 13)[0]  # type: ignore[attr-defined]
        return request[:4] + struct.pack(">HBBHH", 6, request[6], 16, *struct.unpack_from(">HH", request, 8))
    if function == 3 and at == 0:
        return told(request, [answered.number, *READING])  # type: ignore[attr-defined]
    return good(request)


def told(request: bytes, words: list[int]) -> bytes:
    return request[:4] + struct.pack(
        f">HBBB{len(words)}H", 3 + 2 * len(words), request[6], request[7], 2 * len(words), *words
    )


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    monkeypatch.setattr("layflat.rig.drivers.modbus.CONNECT_TIMEOUT", 0.3)
    running = Server()
    yield running
    running.close()


def driver_at(server: Server, reply: Reply) -> ModbusDriver:
    server.reply = reply
    driver = create_driver(f"modbus://127.0.0.1:{server.port}", PATIENT)
    assert isinstance(driver, ModbusDriver)
    return driver


def test_a_station_without_function_23_is_driven_by_16_and_3(server: Server) -> None:
    driver = driver_at(server, refused(1, 23))
    driver.configure()
    driver.activate()
    for volts in (10.0, 0.0, 5.0):
        driver.write(RigCommand(np.array([volts, 0.0]), air=True))
        reading = driver.read()
        assert reading.supply == WIRE.supply.value(1638)
        functions = [request[7] for request in server.requests[-2:]]
        assert functions == [16, 3]
        number, _, count = struct.unpack_from(">HHH", server.requests[-2], 13)
        assert (number, count) == (driver._sequence, WIRE.voltage.count(volts))
    assert [request[7] for request in server.requests].count(23) == 1
    assert driver.remark == "by functions 16 and 3, as the station refuses 23"
    driver.finalize()


def test_its_reading_is_never_that_of_an_older_command(server: Server) -> None:
    """A station that takes the command later than it answers."""

    def behind(request: bytes) -> bytes:
        before = getattr(answered, "number", 0)
        reply = refused(1, 23)(request)
        if request[7] == 16:
            answered.number = before  # type: ignore[attr-defined]
        return reply

    driver = driver_at(server, behind)
    driver.configure()
    with pytest.raises(LinkError, match=r"register 0 holds .* in place of the command's number") as caught:
        driver.read()
    assert caught.value.kind == "sequence"
    driver.finalize()


@pytest.mark.parametrize("code", [*range(2, 12), 99])
def test_an_exception_to_the_command_is_told_by_its_name(server: Server, code: int) -> None:
    driver = driver_at(server, refused(code, 23))
    driver.configure()
    with pytest.raises(LinkError) as caught:
        driver.read()
    assert caught.value.kind == "refused"
    name = EXCEPTION_TEXTS[code][0] if code in EXCEPTION_TEXTS else "a code of its own"
    assert caught.value.reason == f"function 23 is refused: exception {code}, {name}"
    assert caught.value.right
    driver.finalize()


def test_neither_function_is_told(server: Server) -> None:
    driver = driver_at(server, refused(1, 16, 23))
    driver.configure()
    with pytest.raises(LinkError, match="function 16 is refused: exception 1, illegal function") as caught:
        driver.read()
    assert caught.value.right == "let the station serve function 16, or put one before it that does"
    driver.finalize()


@pytest.mark.parametrize(
    ("reply", "what"),
    [
        (
            lambda request: exception(request, 1),
            "function 3 is refused: exception 1, illegal function; let the station serve",
        ),
        (
            lambda request: exception(request, 11),
            "exception 11, gateway target device failed to respond; look at the device",
        ),
        (
            lambda request: exception(request, 10),
            "exception 10, gateway path unavailable; look at the gateway's routes",
        ),
        (lambda request: request[:6] + b"\2" + good(request)[7:], "does not answer as a Modbus station (nothing came"),
        (lambda request: good(request)[:6] + b"\2" + good(request)[7:], "(unit 2 answered in place of unit 1)"),
        (lambda request: b"\0\1" + good(request)[2:], "(only replies to earlier requests came"),
        (lambda request: good(request)[:20], "(the reply broke off after 20 bytes)"),
        (lambda _: b"SSH-2.0-OpenSSH_9.2\r\n", "(what came is no Modbus: b'SSH-2.0-OpenSSH_')"),
        (lambda request: told(request, WORDS[:10]), "unit 1 reports 10 registers where 14 were requested"),
        (lambda request: told(request, [0] * 14), "is not a rig of layflat's: its registers are all 0"),
        (
            lambda request: told(request, [0, *WORDS[:13]]),
            "its identity begins 1 registers later: interface.modbus.identity",
        ),
        (lambda request: told(request, [w >> 8 | (w & 255) << 8 for w in WORDS]), "the bytes of its words are swapped"),
        (lambda request: good(request)[:7] + b"\4" + good(request)[8:], "function 3 is answered as function 4"),
    ],
)
def test_what_a_station_tells_of_itself(server: Server, reply: Reply, what: str) -> None:
    with pytest.raises(DriverError) as error:
        driver_at(server, reply).configure()
    assert what.replace("nothing came", "") in str(error.value)
    assert "\n" not in str(error.value)


def checked(server: Server, reply: Reply) -> CheckResult:
    found = check_rig(PATIENT, driver_at(server, reply), MonotonicClock())
    return next(one for one in found if one.what == "link")


def test_a_check_tells_why_replies_are_no_good(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("layflat.rig.check.CHECK_DURATION", 0.1)
    link = checked(server, refused(6, 23))
    assert "0 of 20 good replies came" in link.finding
    assert "function 23 is refused: exception 6, server device busy" in link.finding
    assert link.action.startswith("one loop drives a rig")
    link = checked(server, refused(1, 23))
    assert "by functions 16 and 3" in link.finding
    numbers = iter(range(1000))
    link = checked(server, lambda request: refused(1, 16, 23)(request) if next(numbers) % 5 < 2 else b"")
    assert "function 16 is refused: exception 1, illegal function" in link.finding, (
        "a refusal says more than late replies"
    )


def test_words_for_what_came() -> None:
    frame = struct.pack(">HHHBB", 7, 0, 2, 1, 3)
    assert describe_missing_reply(b"", 7, 1) == "nothing came in time"
    assert describe_missing_reply(frame[:3], 7, 1) == "the reply broke off after 3 bytes"
    assert describe_missing_reply(frame, 8, 1).startswith("only replies to earlier requests came")
    assert describe_missing_reply(frame, 7, 9) == "unit 1 answered in place of unit 9"
    assert IDENTITY_MAGIC == WORDS[0]
