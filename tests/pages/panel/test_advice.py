"""Whatever happens, the panel has words for it."""

from layflat.pages.panel.status_view import FAULT_ADVICE, REACTION_TEXTS, STATE_TEXTS
from layflat.rig.safety.faults import Fault, Reaction, RigState


def test_every_fault_has_a_reason_and_a_next_step() -> None:
    assert set(FAULT_ADVICE) == set(Fault) - {Fault.NONE}
    for why, next_step in FAULT_ADVICE.values():
        assert why.endswith(".")
        assert next_step.endswith(".")


def test_every_state_and_reaction_is_told() -> None:
    assert set(STATE_TEXTS) == set(RigState)
    assert set(REACTION_TEXTS) == set(Reaction)
