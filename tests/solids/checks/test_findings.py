"""All checks of one joint: tables that close, and findings sorted worst first."""

import pytest

from layflat import extras
from layflat.design.summary import SEVERITY_ORDER
from layflat.solids.checks import findings
from layflat.solids.checks.findings import FINDING_COLUMNS, MASS_COLUMNS, STRESS_COLUMNS, check_build
from tests.solids.checks.builds import built, checked

pytestmark = pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")


def test_tables_have_their_columns_and_all_rows() -> None:
    checks = checked()
    for columns, rows, of in (
        (MASS_COLUMNS, checks.mass_table(), checks.masses),
        (STRESS_COLUMNS, checks.stress_table(), checks.stresses),
        (FINDING_COLUMNS, checks.finding_table(), checks.findings),
    ):
        assert of
        assert [len(row) for row in rows] == [len(columns)] * len(of)
    assert "joint.small.body.mass" in checks._repr_html_()


def test_findings_are_sorted_worst_first_and_of_all_rules() -> None:
    ranks = [SEVERITY_ORDER.index(one.severity) for one in checked().findings]
    assert ranks == sorted(ranks)
    assert {"mass", "hole"} <= {one.rule for one in checked().findings}
    assert 0 not in ranks


def test_progress_goes_up_to_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("joint_clearances", "arm_clearances", "reach_findings"):
        monkeypatch.setattr(findings, name, lambda *_: [])
    steps: list[tuple[int, int]] = []
    check_build(built(), lambda done, of: steps.append((done, of)))
    assert steps[0][0] == 0
    assert steps[-1][0] == steps[-1][1]
    assert steps == sorted(steps)
