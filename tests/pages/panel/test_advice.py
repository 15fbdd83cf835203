"""Whatever happens, the panel has words for it."""

from layflat.pages.panel.advice import DONE, REASONS, STATES
from layflat.rig.safety.faults import Fault, Reaction
from layflat.rig.safety.states import State


def test_every_fault_has_a_reason_and_a_next_step() -> None:
    assert set(REASONS) == set(Fault) - {Fault.NONE}
    for why, next_step in REASONS.values():
        assert why.endswith(".")
        assert next_step.endswith(".")


def test_every_state_and_reaction_is_told() -> None:
    assert set(STATES) == set(State)
    assert set(DONE) == set(Reaction)
