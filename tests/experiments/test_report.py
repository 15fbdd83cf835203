import json
from html.parser import HTMLParser
from pathlib import Path

from layflat.experiments import Reproduction, write_claims, write_report
from layflat.experiments.figures import FIGURES
from layflat.machine.listing import listing


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


def test_the_report_stands_alone_with_figures_in_the_papers_order(paper: Reproduction, tmp_path: Path) -> None:
    assumed = [line for line in listing("paper-arm") if line.source == "assumed"]
    html = write_report(paper, assumed, tmp_path / "report.html").read_text(encoding="utf-8")
    page = Links()
    page.feed(html)
    assert page.outside == []
    assert page.figures == list(FIGURES)
    assert [f for f in page.figures if f.split("-")[1].isdigit()] == [
        *(f"fig-{n}" for n in (2, 3, 4, 5, 6)),
        *(f"fig-{n}" for n in (10, 11, 12, 13, 14)),
    ]
    assert html.count("✓ agrees") == 20
    assert all(title.split(".")[0] in html for title, _, _ in FIGURES.values())
