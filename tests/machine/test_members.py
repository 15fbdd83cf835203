"""Members of the cloud that comes with the machines."""

import numpy as np
import pytest

from layflat.description.change import value_at
from layflat.errors import MachineError
from layflat.machine import load
from layflat.machine.cloud import load_cloud
from layflat.machine.exchanged import member_names, member_values


def test_members_are_machines_by_their_names() -> None:
    names = member_names("paper-arm")
    assert len(names) == len(load_cloud().members) >= 100
    assert load(names[17]) == load("paper-arm@17")
    with pytest.raises(MachineError, match="has no member"):
        load(f"paper-arm@{len(names)}")


@pytest.mark.parametrize("where", ["paper-arm", "paper-small-joint", "paper-arm-fast"])
def test_what_differs_are_the_numbers_of_members_less_gains(where: str) -> None:
    found, names = member_values(where), member_names(where)
    assert "valve.overlap" in found
    assert not any(".gains." in path for path in found)
    for path, numbers in found.items():
        assert numbers[5] == value_at(load(names[5]), path)
        assert np.ptp(numbers) > 0.0


def test_what_a_machine_says_itself_stays() -> None:
    assert "valve.conductance" in member_values("paper-arm")
    assert "valve.conductance" not in member_values("paper-arm-fast")
