"""What a row of a rig's loop says, and where."""

from layflat.rig.named import leaf_names, zero_tuple
from layflat.rig.record import RIG_SIGNALS, SHARED_COLUMNS, RowLayout
from layflat.rig.safety.cycle_numbers import RecordedSignals


def test_the_compiled_cycle_writes_signals_in_the_order_of_the_layout() -> None:
    names = [name.rpartition(".")[2] for name in leaf_names(zero_tuple(RecordedSignals))]
    assert names == list(RIG_SIGNALS)
    layout = RowLayout(("a", "b"), (("phase", ("1", "phase")),))
    assert list(layout.columns) == [*names, "phase", "joint_fault"]
    assert layout.width == len(SHARED_COLUMNS) + 2 * len(layout.columns)
