"""A station asked by pymodbus's own client, and by sockets that do not keep to the protocol."""

from __future__ import annotations

import asyncio
import socket
import struct
import threading
from collections.abc import Iterator
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymodbus.client import ModbusTcpClient

from layflat.rig.clock import VirtualClock
from layflat.rig.device.modbus_server import ModbusStation
from layflat.rig.wire import Identity
from tests.rig.devices import ARM, WIRE, FakeDevice

SAFE = [0, 0x8000, 0x8000]


@pytest.fixture(scope="module")
def station() -> Iterator[SimpleNamespace]:
    clock = VirtualClock()
    device = FakeDevice(clock)
    loop = asyncio.new_event_loop()
    served = ModbusStation(device, ARM)
    port = loop.run_until_complete(served.listen("127.0.0.1", 0))
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    yield SimpleNamespace(port=port, device=device, clock=clock)
    loop.call_soon_threadsafe(served.close)
    loop.call_soon_threadsafe(loop.stop)
    thread.join()
    loop.run_until_complete(asyncio.sleep(0.01))
    loop.close()


@pytest.fixture
def client(station: SimpleNamespace) -> Iterator[ModbusTcpClient]:
    station.clock.wait(station.clock.now() + 10**9)
    found = ModbusTcpClient("127.0.0.1", port=station.port, timeout=2, retries=0)
    assert found.connect()
    yield found
    found.close()


def plain(port: int) -> socket.socket:
    return socket.create_connection(("127.0.0.1", port), timeout=2)


def test_functions_3_4_16_and_23(station: SimpleNamespace, client: ModbusTcpClient) -> None:
    assert (
        client.read_holding_registers(256, count=14).registers
        == Identity.for_machine(ARM, station.device.capabilities).words()
    )
    before = len(station.device.obeyed)
    assert not client.write_registers(0, [70, *SAFE]).isError()
    reading = client.read_input_registers(0, count=7).registers
    assert reading == [70, *WIRE.reading_words(station.device.reading())]
    reply = client.readwrite_registers(read_address=0, read_count=7, write_address=0, values=[71, *SAFE])
    assert reply.registers == [71, *WIRE.reading_words(station.device.reading())]
    assert client.read_holding_registers(2, count=1).registers == [1638]
    assert client.readwrite_registers(read_address=0, read_count=1, write_address=0, values=[71, *SAFE]).registers == [
        71
    ]
    assert len(station.device.obeyed) == before + 2


@pytest.mark.parametrize(
    ("method", "keys", "code"),
    [
        ("read_holding_registers", {"address": 7, "count": 1}, 2),
        ("read_holding_registers", {"address": 0, "count": 8}, 2),
        ("read_input_registers", {"address": 300, "count": 1}, 2),
        ("write_registers", {"address": 0, "values": [1, 2]}, 2),
        ("write_registers", {"address": 1, "values": [1, *SAFE]}, 2),
        ("write_registers", {"address": 0, "values": [1, 8, 0, 0]}, 3),
        ("write_register", {"address": 0, "value": 1}, 1),
        ("read_coils", {"address": 0, "count": 1}, 1),
        ("read_holding_registers", {"address": 256, "count": 14, "device_id": 9}, 11),
    ],
)
def test_what_a_station_refuses(
    station: SimpleNamespace, client: ModbusTcpClient, method: str, keys: dict[str, int], code: int
) -> None:
    before = len(station.device.obeyed)
    reply = getattr(client, method)(**keys)
    assert reply.isError()
    assert reply.exception_code == code
    assert len(station.device.obeyed) == before


def test_functions_that_there_are_not(station: SimpleNamespace) -> None:
    with plain(station.port) as raw:
        raw.sendall(bytes.fromhex("1234 0000 0003 01 63 00"))
        assert raw.recv(100) == bytes.fromhex("1234 0000 0003 01 e3 01")


def test_one_master_at_a_time_until_it_leaves_or_falls_silent(
    station: SimpleNamespace, client: ModbusTcpClient
) -> None:
    other = ModbusTcpClient("127.0.0.1", port=station.port, timeout=2, retries=0)
    assert not client.read_holding_registers(256, count=14).isError()
    assert other.read_holding_registers(256, count=14).exception_code == 6
    station.clock.wait(station.clock.now() + 100_000_000)
    assert other.read_holding_registers(256, count=14).exception_code == 6
    station.clock.wait(station.clock.now() + 100_000_000)
    assert not other.read_holding_registers(256, count=14).isError()
    assert client.read_holding_registers(256, count=14).exception_code == 6
    other.close()
    for _ in range(100):
        reply = client.read_holding_registers(256, count=14)
        if not reply.isError():
            break
    assert not reply.isError()


def test_requests_in_one_piece_are_all_answered(station: SimpleNamespace) -> None:
    station.clock.wait(station.clock.now() + 10**9)
    request = struct.pack(">HHHBBHH", 5, 0, 6, 1, 3, 0, 1)
    with plain(station.port) as raw:
        raw.sendall(request + b"\0\6" + request[2:] + request[:5])
        replies = b""
        while len(replies) < 22:
            replies += raw.recv(100)
        assert (replies[:2], replies[11:13]) == (b"\0\5", b"\0\6")
        raw.sendall(request[5:])
        assert raw.recv(100)[:2] == b"\0\5"


@given(st.binary(min_size=1, max_size=600))
def test_any_bytes_are_survived_and_move_nothing(station: SimpleNamespace, rubbish: bytes) -> None:
    before = len(station.device.obeyed)
    with plain(station.port) as raw:
        raw.sendall(rubbish)
    with plain(station.port) as raw:
        station.clock.wait(station.clock.now() + 10**9)
        raw.sendall(struct.pack(">HHHBBHH", 5, 0, 6, 1, 3, 256, 1))
        assert raw.recv(100) == struct.pack(">HHHBBBH", 5, 0, 5, 1, 3, 2, 0x4C46)
    assert len(station.device.obeyed) == before
