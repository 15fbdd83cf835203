"""What a row of a rig's loop says, and where."""

from layflat.rig.named import blank, leaf_names
from layflat.rig.record import RIG_SIGNALS, SHARED, Layout
from layflat.rig.safety.cycle_numbers import Known


def test_the_compiled_cycle_writes_signals_in_the_order_of_the_layout() -> None:
    names = [name.rpartition(".")[2] for name in leaf_names(blank(Known))]
    assert names == list(RIG_SIGNALS)
    layout = Layout(("a", "b"), (("phase", ("1", "phase")),))
    assert list(layout.columns) == [*names, "phase", "joint_fault"]
    assert layout.width == len(SHARED) + 2 * len(layout.columns)
