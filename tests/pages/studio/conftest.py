import pytest

from layflat.pages.studio.design import Design, open_description


@pytest.fixture
def design() -> Design:
    """The paper's arm, as opened."""
    return Design(open_description("paper-arm"))
