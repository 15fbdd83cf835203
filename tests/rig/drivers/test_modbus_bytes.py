"""The Modbus driver against bytes put together by hand, as the Modbus specification has them: good, bad and random."""

from __future__ import annotations

import socket
import struct
import time
from collections.abc import Iterator
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat import changed
from layflat.rig.driver import DriverError, LinkError, RigCommand
from layflat.rig.drivers import create_driver
from layflat.rig.drivers.modbus import ModbusDriver
from tests.rig.devices import ARM, WIRE
from tests.rig.stations import HASTY, Reply, Server, good


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    running = Server()
    yield running
    running.close()


@pytest.fixture(scope="module")
def driver(server: Server, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModbusDriver]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LAYFLAT_RUNTIME_DIR", str(tmp_path_factory.mktemp("locks")))
        found = create_driver(f"modbus://127.0.0.1:{server.port}", HASTY)
        assert isinstance(found, ModbusDriver)
        found.configure()
    found.activate()
    yield found
    server.reply = good
    found.finalize()


def read_well(driver: ModbusDriver) -> None:
    reading = driver.read()
    assert reading.stopped
    assert reading.angles.tolist() == [WIRE.angle.value(2048), WIRE.angle.value(1000)]
    assert reading.pressures.tolist() == [WIRE.pressure.value(2048), WIRE.pressure.value(3000)]
    assert reading.supply == WIRE.supply.value(1638)


def test_the_request_is_one_of_function_23(server: Server, driver: ModbusDriver) -> None:
    server.reply = good
    driver.write(RigCommand(np.array([10.0, 0.0]), air=True, reset=True))
    read_well(driver)
    request = server.requests[-1]
    number = driver._sequence
    assert request[6:] == struct.pack(">BBHHHHB4H", 1, 23, 0, 7, 0, 4, 8, number, 3, 0xFFFF, 0)


def recovered(server: Server, driver: ModbusDriver) -> None:
    """Good again at once, or after the one cycle that rubbish under way spoils as well."""
    server.reply = good
    with suppress(LinkError):
        read_well(driver)
    for attempt in range(20):
        try:
            return read_well(driver)
        except LinkError:
            assert attempt < 19
    return None


@given(st.binary(max_size=300))
def test_random_bytes_are_never_a_reading(server: Server, driver: ModbusDriver, rubbish: bytes) -> None:
    server.reply = lambda _: rubbish
    with pytest.raises(LinkError):
        driver.read()
    recovered(server, driver)


@given(st.integers(0, 21), st.integers(1, 255))
def test_a_reply_with_any_byte_damaged_is_no_reading_or_says_other_counts(
    server: Server, driver: ModbusDriver, at: int, flip: int
) -> None:
    def damaged(request: bytes) -> bytes:
        reply = good(request)
        return reply[:at] + bytes([reply[at] ^ flip]) + reply[at + 1 :]

    server.reply = damaged
    # From byte 11 on stand flags and counts, which TCP alone protects.
    with suppress(LinkError):
        driver.read()
        assert at >= 11
    recovered(server, driver)


@given(st.integers(0, 22))
def test_a_reply_that_ends_early_is_lost(server: Server, driver: ModbusDriver, size: int) -> None:
    server.reply = lambda request: good(request)[:size]
    with pytest.raises(LinkError):
        driver.read()
    recovered(server, driver)


def test_a_reply_in_pieces_is_taken_if_it_is_in_time(server: Server, driver: ModbusDriver) -> None:
    for server.first in (1, 7, 9, 20):
        recovered(server, driver)
    server.first = 1000


def test_replies_of_cycles_before_are_passed_over(server: Server, driver: ModbusDriver) -> None:
    stale: list[bytes] = []

    def behind(request: bytes) -> bytes:
        stale.append(request)
        return b"".join(good(one) for one in stale)

    server.reply = behind
    for _ in range(4):
        read_well(driver)
    recovered(server, driver)


def test_an_old_number_in_a_fresh_reply_is_told(server: Server, driver: ModbusDriver) -> None:
    def old(request: bytes) -> bytes:
        reply = good(request)
        return reply[:9] + struct.pack(">H", driver._sequence - 1 & 0xFFFF) + reply[11:]

    server.reply = old
    with pytest.raises(LinkError, match="sequence"):
        driver.read()
    recovered(server, driver)


def test_a_trickle_does_not_hold_up_the_cycle(server: Server, driver: ModbusDriver) -> None:
    def slow(request: bytes) -> bytes:
        time.sleep(0.02)
        return good(request)[:8]

    server.reply = slow
    began = time.monotonic()
    with pytest.raises(LinkError, match="lost"):
        driver.read()
    assert time.monotonic() - began < 0.25
    time.sleep(0.02)
    recovered(server, driver)


@pytest.mark.parametrize(
    ("reply", "what"),
    [
        (lambda _: b"", "does not answer as a Modbus station"),
        (lambda _: b"HTTP/1.1 400 Bad Request\r\n\r\n", "does not answer as a Modbus station"),
        (
            lambda request: request[:4] + b"\0\3\1\x83\2",
            "unit 1 does not report registers 256 to 269: function 3 is refused: exception 2, illegal data address",
        ),
        (lambda request: request[:4] + b"\0\3\1\x83\6", "is driven by another master"),
        (lambda request: good(request)[:9] + b"\0" + good(request)[10:], "is not a rig of layflat's"),
    ],
)
def test_what_else_may_listen_at_a_port(reply: Reply, what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("layflat.rig.drivers.modbus.CONNECT_TIMEOUT", 0.2)
    server = Server()
    server.reply = reply
    driver = create_driver(f"modbus://127.0.0.1:{server.port}", HASTY)
    with pytest.raises(DriverError) as error:
        driver.configure()
    server.close()
    assert what in str(error.value)
    assert "\n" not in str(error.value)


def test_nobody_at_a_port() -> None:
    with socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))
        address = f"modbus://127.0.0.1:{closed.getsockname()[1]}"
        with pytest.raises(DriverError, match=f"{address}: can't be reached .*refused.*; give host and port"):
            create_driver(address, ARM).configure()


def test_a_host_without_a_number(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(*_: object, **__: object) -> None:
        raise socket.gaierror(-2, "Name or service not known")

    monkeypatch.setattr(socket, "getaddrinfo", unknown)
    with pytest.raises(DriverError, match="Name or service not known"):
        create_driver("modbus://rig.local", ARM).configure()


def test_a_station_that_comes_back_is_found_again_within_a_cycle_and_one_that_does_not_is_lost() -> None:
    machine = changed(ARM, "interface.modbus.timeout", 0.2)
    server = Server()
    driver = create_driver(f"modbus://127.0.0.1:{server.port}", machine)
    driver.configure()

    def hang_up(request: bytes) -> bytes:
        server.reply = good
        raise ConnectionResetError

    server.reply = hang_up
    with pytest.raises(LinkError, match="lost"):
        driver.read()
    driver.read()
    server.reply = hang_up
    server.close()
    for _ in range(4):
        with pytest.raises(LinkError, match="lost"):
            driver.read()
    driver.finalize()
