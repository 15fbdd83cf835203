from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.sensor import Sensor, read_sensor
from layflat.rig.wire.converter import Converter, WireError

half_ranges = st.floats(1e-3, 1e7)
bits = st.integers(4, 24)


@given(half_ranges, bits, st.floats(-1.2, 1.2))
def test_a_sensors_number_comes_back_bit_for_bit(half: float, bits: int, share: float) -> None:
    sensor = Sensor(-half, half, 2 * half / 2**bits, 0.0, 0.0)
    reported = read_sensor(sensor, share * half, 0.0)
    converter = Converter.of_sensor(sensor)
    words: list[int] = []
    converter.put(words, reported)
    assert len(words) == converter.words
    assert all(0 <= word < 1 << 16 for word in words)
    assert converter.take(words, 0) == reported


@given(half_ranges, bits)
def test_both_ends_of_the_range_have_counts(half: float, bits: int) -> None:
    converter = Converter.of_sensor(Sensor(-half, half, 2 * half / 2**bits, 0.0, 0.0))
    assert converter.top == 2**bits
    assert converter.count(-2 * half) == 0
    assert converter.count(2 * half) == 2**bits
    assert converter.words == (1 if bits < 16 else 2)


@given(bits, st.integers(1, 1 << 30))
def test_a_count_that_no_converter_has_is_refused(bits: int, beyond: int) -> None:
    converter = Converter(0.0, 1.0, 2**bits)
    count = min(converter.top + beyond, (1 << 16 * converter.words) - 1)
    if count > converter.top:
        words = [count >> 16, count & 0xFFFF][-converter.words :]
        with pytest.raises(WireError, match=str(count)):
            converter.take(words, 0)
