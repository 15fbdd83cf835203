"""The table of sizes in docs/export.md has the rows and columns of the benchmark that writes it."""

from benchmarks.export_sizes import MACHINES, PAGE, STEPS, TIMED_TARGET, row_titles, table_of
from tests.export.firmware.boards import BOARDS


def test_the_table_has_the_rows_and_figures_of_the_benchmark() -> None:
    head, _, *rows = (
        [cell.strip() for cell in line.strip("|").split("|")] for line in table_of(PAGE.read_text(encoding="utf-8"))
    )
    assert head == ["target", *MACHINES]
    assert [row[0] for row in rows] == row_titles()
    counts = [3 if target in BOARDS or target == TIMED_TARGET else 2 for target, _ in STEPS]
    for row, count in zip(rows, [*counts, *[1] * (len(rows) - len(counts))], strict=True):
        for cell in row[1:]:
            figures = [int(figure.replace(" ", "")) for figure in cell.split(",")]
            assert len(figures) == count
            assert min(figures) > 0
