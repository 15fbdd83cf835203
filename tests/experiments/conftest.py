"""One reproduction serves all tests of this folder: it is the same for all, and takes seconds."""

import pytest

from layflat.experiments import Reproduction, load_bench, reproduce


@pytest.fixture(scope="session")
def paper() -> Reproduction:
    return reproduce(load_bench())
