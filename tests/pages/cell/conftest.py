from pathlib import Path

import pytest

FEW = """\
extends = "packing"
name = "few"

[tray.infeed]
produce = ["tomato"]
count = { least = 2, most = 2 }

[produce.tomato.diameter]
least = "54 mm"

[produce.tomato.colour.orange]
share = 0.000001
"""


@pytest.fixture(scope="session")
def few(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a cell with two tomatoes in a tray, which can both be packed."""
    path = tmp_path_factory.mktemp("cells") / "few.toml"
    path.write_text(FEW, encoding="utf-8")
    return path
