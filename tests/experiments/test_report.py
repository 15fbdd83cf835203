import json
from dataclasses import replace
from html import unescape
from html.parser import HTMLParser
from pathlib import Path

import pytest

from layflat.experiments import Claim, ClaimQuantity, Reproduction, write_claims, write_report
from layflat.experiments.report import FIGURE_TEXTS, claim_rows, format_number
from layflat.experiments.reproduction import STOPPED_REASON
from layflat.machine.listing import list_values
from layflat.machine.loader import tables


class Links(HTMLParser):
    """Collects what a page would load from elsewhere."""

    def __init__(self) -> None:
        super().__init__()
        self.outside: list[str] = []
        self.figures: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for key, value in attrs:
            if key in {"src", "href", "xlink:href"} and value and not value.startswith("#"):
                self.outside.append(value)
        if tag == "figure":
            self.figures.append(dict(attrs).get("id") or "")


def test_claims_json_is_a_list_of_records(paper: Reproduction, tmp_path: Path) -> None:
    records = json.loads(write_claims(paper, tmp_path / "claims.json").read_text(encoding="utf-8"))
    assert len(records) == 20
    for record in records:
        assert {"id", "where", "paper", "simulated", "unit", "agrees"} <= set(record)
        assert record["agrees"] is True


@pytest.fixture(scope="module")
def html(paper: Reproduction, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The report of the paper's arm."""
    assumed = [line for line in list_values(*tables("paper-arm")) if line.source == "assumed"]
    return write_report(paper, assumed, tmp_path_factory.mktemp("report") / "r.html").read_text(encoding="utf-8")


def test_the_report_stands_alone_with_figures_in_the_papers_order(html: str) -> None:
    page = Links()
    page.feed(html)
    assert page.outside == []
    assert page.figures == list(FIGURE_TEXTS)
    assert [f for f in page.figures if f.split("-")[1].isdigit()] == [
        *(f"fig-{n}" for n in (2, 3, 4, 5, 6)),
        *(f"fig-{n}" for n in (10, 11, 12, 13, 14)),
    ]
    assert html.count("✓ agrees") == 20
    assert all(texts["title"].split(".")[0] in unescape(html) for texts in FIGURE_TEXTS.values())


def partly(paper: Reproduction, evaluated: set[str]) -> Reproduction:
    """A reproduction that was stopped when it had evaluated so many claims."""
    claims = [
        claim
        if claim.id in evaluated
        else Claim(claim.id, claim.where, claim.says, claim.criterion, reason=STOPPED_REASON)
        for claim in paper.claims
    ]
    return replace(paper, claims=claims)


def test_every_number_of_the_claims_stands_in_the_report(paper: Reproduction, html: str) -> None:
    for claim in paper.claims:
        part = html.partition(f'<tbody id="{claim.id}">')[2].partition("</tbody>")[0]
        for one in claim.quantities:
            shown = format_number(one.value).replace("<", "&lt;")
            assert f">{one.name}<" in part
            assert f">{shown}<" in part
            assert f">{one.paper}<" in part


def test_what_was_not_judged_is_said_and_not_drawn(paper: Reproduction, tmp_path: Path) -> None:
    found = partly(paper, {"table-1", "rig-variants", "averaging"})
    html = write_report(found, [], tmp_path / "report.html").read_text(encoding="utf-8")
    page = Links()
    page.feed(html)
    assert page.figures == ["fig-2", "fig-3", "fig-4", "fig-5", "fig-average"]
    assert html.count("✓ agrees") == 3
    assert html.count(f">{STOPPED_REASON}<") == 17
    assert "3 of 3 claims agree; partial: stopped before 17 were evaluated" in html
    records = json.loads(write_claims(found, tmp_path / "claims.json").read_text(encoding="utf-8"))
    assert [record["agrees"] for record in records].count(None) == 17


@pytest.mark.parametrize(
    ("value", "text"),
    [(1.2111e-13, "< 0.0001"), (0.0, "0"), (float("inf"), "never"), (1e6, "1,000,000"), (-3.25, "-3.25")],
)
def test_numbers_as_people_read_them(value: float, text: str) -> None:
    assert format_number(value) == text


def test_a_row_for_each_quantity_or_for_the_reason() -> None:
    several = Claim("a", "1", "", "", (ClaimQuantity("x", 1.0, "m", "2"), ClaimQuantity("y", 2.0)), agrees=False)
    none = Claim("b", "2", "", "", reason="not applicable: no arm")
    assert claim_rows([several, none]) == [
        ["a", "x", "2", "1", "m", "NO"],
        ["", "y", "", "2", "", ""],
        ["b", "not applicable: no arm", "", "", "", "-"],
    ]
