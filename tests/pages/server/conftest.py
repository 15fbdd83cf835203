from collections.abc import Iterator

import pytest

from tests.pages.server.serving import Served, serving


@pytest.fixture(scope="session")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server that many tests ask; they leave it as it is."""
    pytest.importorskip("nicegui", reason="needs the extra 'panel'")
    complaints: list[str] = []
    with serving(tmp_path_factory.mktemp("served"), complaints=complaints) as found:
        yield found
    assert all("is too long" in line for line in complaints), complaints
