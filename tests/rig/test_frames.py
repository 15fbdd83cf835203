"""The host's frames and the microcontroller's: the same tests for both, and each reads the other's."""

from __future__ import annotations

import random
import struct
from typing import Any
from zlib import crc32

import pytest
from cobs import cobs
from hypothesis import given
from hypothesis import strategies as st

from layflat.rig import frames as host
from layflat.rig.wire import WireError
from tests.rig.firmwares import firmware

SIDES = {"host": host, "firmware": firmware("frames")}
BOTH = [(one, other) for one in SIDES for other in SIDES]

kinds = st.sampled_from([host.IDENTIFY_FRAME, host.COMMAND_FRAME, host.IDENTITY_FRAME, host.READING_FRAME])
messages = st.tuples(kinds, st.integers(0, 0xFFFF), st.binary(max_size=60))
Message = tuple[int, int, bytes]


def fed(side: Any, stream: bytes, seed: int = 0) -> tuple[list[Message], int]:
    """What a decoder makes of a stream that comes in random pieces, and how much it calls bad."""
    decoder, chance, found, at = side.Decoder(), random.Random(seed), [], 0
    while at < len(stream):
        size = chance.randint(1, 40)
        found += decoder.feed(stream[at : at + size])
        at += size
    return [tuple(frame) for frame in found], decoder.bad


@given(messages, st.binary(max_size=240))
def test_both_sides_make_the_same_bytes(message: Message, payload: bytes) -> None:
    for content in (message, (message[0], message[1], payload)):
        assert host.encode(*content) == SIDES["firmware"].encode(*content)


@given(st.binary(max_size=100))
def test_the_firmwares_own_checks_are_the_libraries(data: bytes) -> None:
    assert SIDES["firmware"].own_crc32(data) == crc32(data)
    assert SIDES["firmware"].stuffed(data) == cobs.encode(data)
    assert SIDES["firmware"].unstuffed(cobs.encode(data)) == data


@pytest.mark.parametrize(("one", "other"), BOTH)
@given(sent=st.lists(messages, max_size=6), seed=st.integers(0, 99))
def test_frames_arrive_whole_in_whatever_pieces(one: str, other: str, sent: list[Message], seed: int) -> None:
    stream = b"".join(SIDES[one].encode(*message) for message in sent)
    assert fed(SIDES[other], stream, seed) == (sent, 0)


damage = st.sampled_from(["whole", "cut", "headless", "twice", "flipped", "noise", "joined"])


def damaged(frame: bytes, how: str, chance: random.Random) -> tuple[bytes, int]:
    """A frame after an accident, and how often it is still whole."""
    at = chance.randrange(1, len(frame) - 1)
    return {
        "whole": (frame, 1),
        "cut": (frame[:at], 0),
        "headless": (b"\0" + frame[at + 1 :], 0),
        "twice": (frame + frame, 2),
        "flipped": (frame[:at] + bytes([frame[at] ^ 1 << chance.randrange(8)]) + frame[at + 1 :], 0),
        "noise": (chance.randbytes(chance.randrange(1, 600)) + frame, 1),
        "joined": (frame[:-1] + frame[1:], 0),
    }[how]


@pytest.mark.parametrize("side", SIDES)
@given(sent=st.lists(st.tuples(messages, damage), max_size=8), seed=st.integers(0, 10**6))
def test_no_accident_yields_a_wrong_frame_or_costs_a_neighbour(
    side: str, sent: list[tuple[Message, str]], seed: int
) -> None:
    chance = random.Random(seed)
    stream, whole = b"", []
    for message, how in sent:
        data, times = damaged(host.encode(*message), how, chance)
        stream += data
        whole += [message] * times
    found, bad = fed(SIDES[side], stream, seed)
    assert found == whole
    if all(how in ("whole", "twice") for _, how in sent):
        assert bad == 0


@pytest.mark.parametrize("side", SIDES)
@given(chunks=st.lists(st.binary(max_size=300), max_size=10))
def test_any_bytes_are_survived_and_bounded(side: str, chunks: list[bytes]) -> None:
    decoder = SIDES[side].Decoder()
    for chunk in chunks:
        assert decoder.feed(chunk) == []
        assert len(decoder._tail) <= host.MAX_FRAME_BYTES
    assert [tuple(frame) for frame in decoder.feed(host.encode(2, 7, b"after"))] == [(2, 7, b"after")]


@pytest.mark.parametrize("side", SIDES)
def test_an_endless_frame_is_one_bad_one(side: str) -> None:
    decoder = SIDES[side].Decoder()
    for _ in range(100):
        decoder.feed(b"x" * 100)
    assert decoder.bad == 0
    decoder.feed(b"\0")
    assert decoder.bad == 1


@pytest.mark.parametrize("side", SIDES)
def test_another_version_is_no_frame(side: str) -> None:
    body = struct.pack(">BBH", host.VERSION + 1, 2, 7) + b"hello"
    stream = b"\0" + cobs.encode(body + struct.pack(">I", crc32(body))) + b"\0"
    assert fed(SIDES[side], stream) == ([], 1)


@given(st.lists(st.integers(0, 0xFFFF), max_size=20))
def test_words_go_there_and_back(words: list[int]) -> None:
    assert list(host.unpack_words(host.pack_words(words))) == words
    with pytest.raises(WireError, match="bytes"):
        host.unpack_words(host.pack_words(words) + b"x")
