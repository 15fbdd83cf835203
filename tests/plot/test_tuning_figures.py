import numpy as np
import pytest
import xarray

from layflat.plot.style import to_svg
from layflat.plot.tuning import cost_figure, response_figure, settled_fraction_figure
from layflat.sim import rollout
from tests.plot.looks import covered, cut_off, line_of

JOINTS = ("base", "shoulder", "elbow", "wrist", "hand")
SETTLING = {"before": np.array([[0.2, np.inf], [0.6, 0.4]]), "after": np.array([[0.1, 0.2], [0.3, 0.2]])}


def test_shares_end_at_what_ever_settles() -> None:
    (axes,) = settled_fraction_figure(SETTLING, 1.5, 1.7).axes
    before, after = axes.lines[:2]
    assert np.asarray(before.get_ydata())[-1] == pytest.approx(75.0)
    assert np.asarray(after.get_ydata())[-1] == pytest.approx(100.0)
    assert np.asarray(before.get_xdata())[-1] == 1.7


def test_nothing_settled_is_a_line_at_zero() -> None:
    (axes,) = settled_fraction_figure({"before": np.full((3, 2), np.inf)}, 1.5, 1.7).axes
    assert np.asarray(axes.lines[0].get_ydata()).tolist() == [0.0]


def test_every_axis_has_its_unit_and_the_same_data_give_the_same_bytes() -> None:
    runs = {"before": rollout("paper-arm", "10 deg", start=0.0, duration=0.3)}

    def drawn() -> list[str]:
        made = (
            response_figure(runs, band=0.005, since=0.1),
            settled_fraction_figure(SETTLING, 1.5, 1.7),
            cost_figure([3, 2], {"a": 0}),
        )
        assert all(axes.get_ylabel().endswith(")") for figure in made for axes in figure.axes)
        return [to_svg(figure) for figure in made]

    assert drawn() == drawn()


@pytest.mark.parametrize("joints", [1, 2, 3, 4, 5])
def test_joints_of_an_arm_stand_two_beside_each_other(joints: int) -> None:
    time = np.linspace(0.0, 1.0, 51)
    moved = np.degrees(0.1) * np.tile(np.minimum(4.0 * time, 1.0)[:, None], joints)
    angles = {
        name: (("time", "joint"), np.radians(values)) for name, values in (("angle", moved), ("demand", moved > 0.0))
    }
    run = xarray.Dataset(angles, {"time": time, "joint": list(JOINTS[:joints])})
    made = response_figure({"after": run}, band=0.005, since=0.1)
    shown = [axes for axes in made.axes if axes.get_visible()]
    assert len(shown) == 2 * joints
    assert [axes.get_title(loc="left") for axes in shown if axes.get_title(loc="left")] == [
        f"{name} joint" for name in JOINTS[:joints]
    ]
    assert made.get_figwidth() <= 9.4
    assert cut_off(made) == []
    assert sum(axes.get_xlabel() == "Time (s)" for axes in shown) == min(joints, 2)


def test_a_limit_is_named_and_shares_rise() -> None:
    made = settled_fraction_figure(SETTLING, 1.5, 1.7)
    (axes,) = made.axes
    assert [text.get_text() for text in axes.texts] == ["1.5 s"]
    for label, times in SETTLING.items():
        x, y = line_of(axes, label)
        assert (np.diff(y) >= 0).all()
        for time in (0.25, 0.5):
            share = y[np.searchsorted(x, time, side="right") - 1] if (x <= time).any() else 0.0
            assert share == pytest.approx(100 * (times <= time).mean())
    assert covered(made) == []
    assert cut_off(made) == []


PARTS = ["large joint, far", "large joint, near", "large joint, close", "small joint, far", "small joint, integral"]


@pytest.mark.parametrize("begun", [(0, 20, 40, 60, 80), (0, 5, 90, 95, 100)])
def test_parts_of_a_search_are_named_where_they_began_and_within_the_figure(begun: tuple[int, ...]) -> None:
    made = cost_figure(list(np.linspace(3.0, 1.0, 101)), dict(zip(PARTS, begun, strict=True)))
    (axes,) = made.axes
    assert [text.get_text() for text in axes.texts] == PARTS
    centres = [
        axes.transData.inverted().transform(text.get_window_extent().get_points()).mean(axis=0)[0]
        for text in axes.texts
    ]
    assert centres == pytest.approx(begun, abs=1.0)
    assert covered(made) == []
    assert cut_off(made) == []


def test_a_search_in_one_part_needs_no_names() -> None:
    (axes,) = cost_figure([3.0, 2.0], {"all gains": 0}).axes
    assert not axes.texts
    assert len(axes.lines) == 1
