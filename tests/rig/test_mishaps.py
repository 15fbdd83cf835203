"""Rules that hold in every cycle, whatever is requested and whatever fails."""

import re

import pytest

from layflat.machine import load
from layflat.rig.device_state import DeviceState
from layflat.rig.safety.cycle_numbers import max_events
from layflat.rig.safety.faults import Fault, Reaction, RigState, ValveMode
from layflat.rig.safety.state_machine import RESET_HIGH_CYCLES, RESET_LOW_CYCLES
from layflat.rig.safety.supervisor import REFUSAL_TEXTS
from tests.rig.fake_rig import Rig
from tests.rig.mishaps import MishapRig

OFF, STARTING, READY, MOVING, HOLDING, STOPPED, FAULT = RigState
NEXT_STATES = {
    OFF: {STARTING, FAULT},
    STARTING: {READY, STOPPED, FAULT},
    READY: {MOVING, HOLDING, STOPPED, FAULT},
    MOVING: {HOLDING, STOPPED, FAULT},
    HOLDING: {READY, STOPPED, FAULT},
    STOPPED: {STARTING, FAULT},
    FAULT: {OFF, HOLDING},
}
CYCLES = 4000


def state_changes(lines: list[str]) -> list[tuple[str, ...]]:
    return [tuple(line.split(" -> ")) for line in lines if " -> " in line]


def present_faults(rig: Rig) -> set[str]:
    """Texts of the faults of this cycle."""
    core, faults = rig.supervisor.core, list(Fault)[1:]
    texts = {fault.title for fault in faults if int(core.machine["present"][0]) >> fault & 1}
    for name, bits in zip(rig.driver.machine.joints, core.memory["present"], strict=True):
        texts |= {f"joint {name!r}: {fault.title}" for fault in faults if int(bits) >> fault & 1}
    return texts


@pytest.mark.parametrize("name", ["paper-arm-fast", "paper-small-joint"])
@pytest.mark.parametrize("seed", [0, 1])
def test_rules_hold_whatever_happens(name: str, seed: int) -> None:
    mishaps = MishapRig(load(name), seed)
    supervisor, ledger = mishaps.rig.supervisor, mishaps.rig.supervisor.ledger
    before, faults_before, lost, outputs, resets = OFF, set[str](), 0, 0, []
    for rig in mishaps.cycles(CYCLES):
        lines, command, state = rig.take_lines(), rig.driver.commands[-1], supervisor.state
        faults, core = present_faults(rig), supervisor.core
        # Events tell each change of the state, and each fault as it comes.
        path = state_changes(lines)
        states = [before.name.lower(), *(after for _, after in path)]
        assert [one for one, _ in path] == states[:-1]
        assert states[-1] == state.name.lower()
        told = [line for line in lines if line not in REFUSAL_TEXTS.values() and " -> " not in line]
        assert (len(told), set(told)) == (len(set(told)), faults - faults_before)
        assert core.results["events"][0] < max_events(len(core.memory.array))
        for one, other in path:
            assert RigState[other.upper()] in NEXT_STATES[RigState[one.upper()]]
        # Latched faults alone make FAULT, and their reaction is done at once.
        assert (state is FAULT) == (ledger.latched is not Fault.NONE)
        assert ledger.reaction >= ledger.latched.reaction
        assert ledger.worst == max(ledger.latched, ledger.now)
        assert not (command.air and ledger.reaction >= Reaction.VENT_JOINT)
        assert command.air == (supervisor.valve_mode in {ValveMode.HOLD, ValveMode.FOLLOW})
        assert (supervisor.valve_mode is ValveMode.FOLLOW) == (state is MOVING)
        assert not (rig.host.age > 0.1 and {before, state} <= {READY, MOVING, HOLDING})
        # Commands are in range, and a rig without air is centred or vented.
        assert ((command.voltages >= 0.0) & (command.voltages <= 10.0)).all()
        assert command.air or set(command.voltages) <= {0.0, 5.0, 10.0}
        lost = lost + 1 if rig.driver.link is not None else 0
        assert supervisor.lost == lost
        assert (Fault.LINK_LOST.title in faults) == (lost >= Fault.LINK_LOST.cycles)
        for number, on in mishaps.switched:
            outputs = outputs | 1 << number if on else outputs & ~(1 << number)
        outputs = 0 if rig.driver.device is DeviceState.DUMPED and lost == 0 else outputs
        assert command.outputs == outputs
        resets.append(command.reset)
        before, faults_before = state, faults
    # A pulse of the reset bit is low for some cycles before it is high.
    bits = "".join("01"[reset] for reset in resets)
    pulses = re.findall(r"(0*)(1+)", bits)
    assert all(len(low) >= RESET_LOW_CYCLES and len(high) <= RESET_HIGH_CYCLES for low, high in pulses)
    assert len(pulses) > 10
    assert sum(mishaps.counts.values()) > 5
