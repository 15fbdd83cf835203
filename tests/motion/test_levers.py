from pathlib import Path

import numpy as np
import pytest

from layflat.machine import load
from layflat.motion.kinematics import joints_not_moving_tip, tip_levers


def test_levers_of_a_planar_arm_are_those_of_the_stretched_arm() -> None:
    levers = tip_levers(load("paper-arm"))
    assert levers[1] == pytest.approx(0.4)
    assert 0.75 < levers[0] <= 0.8


@pytest.mark.parametrize(("tool", "names"), [("180 mm", ["wrist"]), ("0 mm", ["wrist"])])
def test_a_wrist_about_the_tip_is_named(tool: str, names: list[str], tmp_path: Path) -> None:
    file = tmp_path / "turned.toml"
    file.write_text(
        'extends = "picking-arm"\nname = "turned"\n[arm.link.wrist]\naxis = [1.0, 0.0, 0.0]\n'
        f'[arm]\ntool = ["{tool}", "0 mm", "0 mm"]\n'
    )
    assert joints_not_moving_tip(load(file)) == names
    assert joints_not_moving_tip(load("picking-arm")) == []
    assert np.all(tip_levers(load("picking-arm")) > 0.1)
