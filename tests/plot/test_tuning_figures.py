import numpy as np
import pytest

from layflat.plot.style import to_svg
from layflat.plot.tuning import cost_history, responses, settled_shares
from layflat.sim import rollout

SETTLING = {"before": np.array([[0.2, np.inf], [0.6, 0.4]]), "after": np.array([[0.1, 0.2], [0.3, 0.2]])}


def test_shares_end_at_what_ever_settles() -> None:
    (axes,) = settled_shares(SETTLING, 1.5, 1.7).axes
    before, after = axes.lines[:2]
    assert np.asarray(before.get_ydata())[-1] == pytest.approx(75.0)
    assert np.asarray(after.get_ydata())[-1] == pytest.approx(100.0)
    assert np.asarray(before.get_xdata())[-1] == 1.7


def test_nothing_settled_is_a_line_at_zero() -> None:
    (axes,) = settled_shares({"before": np.full((3, 2), np.inf)}, 1.5, 1.7).axes
    assert np.asarray(axes.lines[0].get_ydata()).tolist() == [0.0]


def test_every_axis_has_its_unit_and_the_same_data_give_the_same_bytes() -> None:
    runs = {"before": rollout("paper-arm", "10 deg", start=0.0, duration=0.3)}

    def drawn() -> list[str]:
        made = (
            responses(runs, band=0.005, since=0.1),
            settled_shares(SETTLING, 1.5, 1.7),
            cost_history([3, 2], {"a": 0}),
        )
        assert all(axes.get_ylabel().endswith(")") for figure in made for axes in figure.axes)
        return [to_svg(figure) for figure in made]

    assert drawn() == drawn()
