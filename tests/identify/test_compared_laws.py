"""Which of several laws is taken."""

from types import SimpleNamespace
from typing import Any

import pytest

from layflat.identify.identification import LawCandidate, compare_candidates


def candidates(*names: str) -> list[LawCandidate]:
    return [LawCandidate(name, None, SimpleNamespace(remarks=())) for name in names]  # type: ignore[arg-type]


def taken(errors: dict[str, float], *, partial: str = "") -> Any:
    """The fit that is taken of laws that miss the validation so much, the simplest first."""
    of = candidates(*errors)

    def fitted(_: int, one: LawCandidate) -> Any:
        missed = [SimpleNamespace(relative_rms=errors[one.name])]
        return SimpleNamespace(model=one.model, predictions=missed, partial=one.name == partial, name=one.name)

    return compare_candidates(of, fitted)


@pytest.mark.parametrize(
    ("errors", "name", "said"),
    [
        ({"simple": 0.05, "richer": 0.01}, "richer", "Richer predicts best"),
        ({"simple": 0.01, "richer": 0.05}, "simple", "Simple predicts best"),
        ({"simple": 0.0105, "richer": 0.01}, "simple", "the logs can't tell them apart"),
        ({"simple": 0.0012, "richer": 0.0004}, "simple", "the logs can't tell them apart"),
        ({"simple": float("nan"), "richer": 0.2}, "richer", "simple inf %"),
    ],
)
def test_the_simplest_that_predicts_as_well_is_taken(errors: dict[str, float], name: str, said: str) -> None:
    found = taken(errors)
    assert found.name == name
    assert said in found.model.remarks[-1]
    assert "simple" in found.model.remarks[-1]
    assert "richer" in found.model.remarks[-1]


def test_one_law_is_not_compared() -> None:
    assert taken({"only": 0.3}).model.remarks == ()


def test_a_search_that_is_stopped_ends_the_comparison() -> None:
    found = taken({"simple": 0.5, "richer": 0.01, "richest": 0.001}, partial="richer")
    assert (found.name, found.model.remarks) == ("richer", ())
