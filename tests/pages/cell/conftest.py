from pathlib import Path

import pytest

from tests.cli.few_tomatoes import FEW


@pytest.fixture(scope="session")
def few(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a cell with two tomatoes in a tray, which can both be packed."""
    path = tmp_path_factory.mktemp("cells") / "few.toml"
    path.write_text(FEW, encoding="utf-8")
    return path
