from pathlib import Path

import numpy as np
import pytest
import xarray

from layflat.errors import InputError, OutputError
from layflat.machine import Machine, load
from layflat.motion.kinematics import tip_position
from layflat.sim import rollout
from layflat.sim.dataset import open_run, save_run


def test_a_run_comes_back_from_disk_as_it_was(tmp_path: Path) -> None:
    run = rollout("paper-arm", "5 deg", duration=0.1)
    back = open_run(save_run(run, tmp_path / "run.nc"))
    xarray.testing.assert_equal(run, back)
    assert Machine.model_validate_json(back.attrs["machine"]) is not None


def test_a_place_that_can_not_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(OutputError, match="can't write here"):
        save_run(rollout("paper-arm", duration=0.01), tmp_path / "file" / "run.nc")


def test_a_file_that_is_no_run(tmp_path: Path) -> None:
    (tmp_path / "x.nc").write_text("no")
    with pytest.raises(InputError, match="can't be read as a run"):
        open_run(tmp_path / "x.nc")


def test_tip_of_a_stretched_and_of_a_bent_arm() -> None:
    arm = load("paper-arm")
    reach = sum(joint.planar_link.length for joint in arm.joints.values())
    assert tip_position(arm, np.array([0.0, -arm.arm.elbow])) == pytest.approx([reach, 0.0], abs=1e-12)
    assert tip_position(arm, np.array([0.0, 0.0])) == pytest.approx([0.4, 0.4], abs=1e-12)
