import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.sensor import Sensor, read_sensor

SENSOR = Sensor(-1.0, 1.0, 2.0 / 4096, 0.0, 0.0)


@given(st.floats(-1.0, 1.0))
def test_one_count_wide(y: float) -> None:
    read = read_sensor(SENSOR, y, 0.0)
    assert abs(read - y) <= 0.5 * SENSOR.lsb * (1 + 1e-9)
    counts = (read - SENSOR.low) / SENSOR.lsb
    assert counts == pytest.approx(round(counts), abs=1e-9)


@given(st.floats(-10.0, 10.0), st.floats(-5.0, 5.0))
def test_reads_within_its_range(y: float, normal: float) -> None:
    noisy = SENSOR._replace(noise=0.5, offset=0.1)
    assert noisy.low <= read_sensor(noisy, y, normal) <= noisy.high + 0.5 * noisy.lsb


def test_offset_and_noise_add() -> None:
    shifted = SENSOR._replace(offset=0.1, noise=0.02)
    assert read_sensor(shifted, 0.2, 2.0) == pytest.approx(0.34, abs=SENSOR.lsb)
    assert read_sensor(shifted, 0.2, -2.0) == pytest.approx(0.26, abs=SENSOR.lsb)
