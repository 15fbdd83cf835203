from collections.abc import Iterator

import pytest
from tests.pages.server.serving import Served, serving


@pytest.fixture(scope="session")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server that many tests ask; they leave it as it is."""
    pytest.importorskip("nicegui", reason="needs the extra 'panel'")
    with serving(tmp_path_factory.mktemp("served")) as found:
        yield found
