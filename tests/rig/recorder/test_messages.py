"""Messages, against the general decoder of ROS 2."""

from io import BytesIO
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.records import Message, Schema
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from numpy.typing import NDArray

from layflat.rig.record import SHARED_COLUMNS, RowLayout
from layflat.rig.recorder.bag import (
    CYCLE_TYPE,
    JOINT_STATE_TYPE,
    LOG_TYPE,
    BagWriter,
    LogHeading,
    MessageCodec,
    encode_event,
    schema_definitions,
)
from layflat.rig.recorder.ring import Event, EventLevel
from tests.rig.recorder.rigrows import BEGIN, LAW, LAYOUT

NAMES = st.lists(st.text("abcdefghijklmnopq_é", min_size=1, max_size=9), min_size=1, max_size=4, unique=True)


FACTORY = DecoderFactory()


def encoded(layout: RowLayout, made: NDArray[np.float64]) -> tuple[list[bytes], list[bytes]]:
    """Cycles and joint states of rows, as a log has them."""
    stream = BytesIO()
    bag = BagWriter(stream, LogHeading(layout, "{}", "arm"), BEGIN, chunked=False)
    bag.add(made)
    bag.finish()
    stream.seek(0)
    found = [record.data for record in StreamReader(stream).records if isinstance(record, Message)]
    return found[::2], found[1::2]


def decoded(kind: str, data: bytes) -> Any:
    schemas = schema_definitions(LAYOUT)
    number = list(schemas).index(kind) + 1
    decode = FACTORY.decoder_for("cdr", Schema(number, schemas[kind].encode(), "ros2msg", kind))
    assert decode is not None
    return decode(data)


@given(NAMES, st.integers(0, 2**31))
def test_the_general_decoder_reads_every_number(joints: list[str], seed: int) -> None:
    layout = RowLayout(tuple(joints), LAW)
    made = np.random.default_rng(seed).normal(size=(2, layout.width))
    made[:, 0] = 0.0, 5.000001e-3
    stamps = BEGIN + np.array([0, 5_000_001])
    cycles, states = encoded(layout, made)
    for row, stamp, cycle, state in zip(made, stamps.tolist(), cycles, states, strict=True):
        read, shown = decoded(CYCLE_TYPE, cycle), decoded(JOINT_STATE_TYPE, state)
        for message in (read, shown):
            assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp
            assert message.name == joints
        assert [getattr(read, name) for name in SHARED_COLUMNS] == row[: len(SHARED_COLUMNS)].tolist()
        by_joint = row[len(SHARED_COLUMNS) :].reshape(len(joints), -1)
        for i, name in enumerate(layout.by_joint):
            assert list(getattr(read, name)) == [float(values[i]) for values in by_joint]
        assert list(shown.position) == list(read.measured_angle)
        assert list(shown.velocity) == list(read.averaged_velocity)
        assert list(shown.effort) == []


@given(NAMES, st.integers(1, 5))
def test_what_was_encoded_is_decoded_bit_for_bit(joints: list[str], count: int) -> None:
    layout = RowLayout(tuple(joints), LAW)
    made = np.random.default_rng(count).normal(size=(count, layout.width))
    made[0, -1] = np.nan
    columns = MessageCodec(schema_definitions(layout)[CYCLE_TYPE], joints).decode(encoded(layout, made)[0])
    assert list(columns) == [*SHARED_COLUMNS, *layout.by_joint]
    for i, name in enumerate(SHARED_COLUMNS):
        assert np.array_equal(columns[name], made[:, i])
    for i, name in enumerate(layout.by_joint):
        expected = made[:, len(SHARED_COLUMNS) :].reshape(count, len(joints), -1)[:, :, i]
        assert np.array_equal(columns[name], expected, equal_nan=True)


def test_messages_of_other_joints_are_not_taken_for_ours() -> None:
    definition = schema_definitions(LAYOUT)[CYCLE_TYPE]
    cycles, _ = encoded(LAYOUT, np.ones((1, LAYOUT.width)))
    with pytest.raises(ValueError, match="other joints"):
        MessageCodec(definition, ["small", "large"]).decode(cycles)
    with pytest.raises(ValueError, match="reshape"):
        MessageCodec(definition, ["large"]).decode(cycles)


@given(st.text(max_size=50).filter(lambda text: "\0" not in text), st.sampled_from(EventLevel))
def test_the_general_decoder_reads_events(text: str, level: EventLevel) -> None:
    message = decoded(LOG_TYPE, encode_event(BEGIN + 7, Event(0.0, level, text)))
    assert (message.msg, message.level, message.name) == (text, level, "layflat.rig")
    assert message.stamp.sec * 10**9 + message.stamp.nanosec == BEGIN + 7
