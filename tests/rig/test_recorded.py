"""Names of logs."""

from pathlib import Path

import pytest

from layflat.rig.recorded import free_log_path


@pytest.mark.parametrize("name", ["arm", "arm[1]", "arm*", "a?m"])
def test_a_name_with_any_file_of_its_stem_is_taken(tmp_path: Path, name: str) -> None:
    (tmp_path / f"{name}.csv").touch()
    assert free_log_path(tmp_path, name) == tmp_path / f"{name}-2.mcap"


@pytest.mark.parametrize("name", ["arm[1]", "arm*", "a?m"])
def test_signs_of_patterns_in_a_name_stand_for_themselves(tmp_path: Path, name: str) -> None:
    for other in ("arm", "arm1", "arms"):
        (tmp_path / f"{other}.csv").touch()
    assert free_log_path(tmp_path, name) == tmp_path / f"{name}.mcap"
