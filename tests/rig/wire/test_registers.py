from __future__ import annotations

import pytest

from layflat import changed, load
from layflat.errors import MachineError
from layflat.rig.wire.registers import Registers

ARM = load("paper-arm")


def test_the_map_that_the_docs_show() -> None:
    found = Registers.of(ARM)
    assert found == (range(4), range(7), range(256, 270))


@pytest.mark.parametrize(
    ("path", "value", "what"),
    [
        ("interface.modbus.readings", 65530, "7 registers from 65530 on go beyond 65535"),
        ("interface.modbus.commands", 65533, "4 registers from 65533 on"),
        ("interface.modbus.identity", 5, "register 5 is too near to the readings"),
    ],
)
def test_maps_that_can_not_be(path: str, value: int, what: str) -> None:
    with pytest.raises(MachineError, match=what) as error:
        Registers.of(changed(ARM, path, value))
    assert path in str(error.value)
