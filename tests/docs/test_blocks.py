"""Blocks of code on the pages run as they stand, and print what the pages show."""

import re
from pathlib import Path

import pytest

from tests.docs.blocks import PAGES, Block, commands, read_blocks
from tests.docs.reader import NOT_RUN, PageError, Reader, check_descriptions
from tests.docs.setups import SETUPS

ELSEWHERE = {"kinds": "tests/test_outside_kinds.py"}
"""Pages whose blocks are run by a test of their own."""

GENERATED = {"arm-conformance"}
"""Pages that commands write."""

MAX_WORDS = 38_000
CODE = re.compile(r"^```.*?^```$|<!--.*?-->|^(?: {4}\S[^\n]*\n)+", re.MULTILINE | re.DOTALL)
LANGUAGES = {"python", "sh", "toml", "output", "text"}


@pytest.mark.parametrize("page", [page for page in PAGES if page.stem not in ELSEWHERE], ids=lambda page: page.stem)
def test_blocks_run_and_print_what_is_shown(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "agg")
    blocks, prepare = read_blocks(page), SETUPS.get(page.stem)
    reader = Reader(tmp_path, prepare(tmp_path) if prepare else {})
    for block in blocks:
        reader.read(block)
    assert list(check_descriptions(blocks, tmp_path)) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_no_output_stays_uncompared(page: Path) -> None:
    """Plain text carries a reason why it is not compared, and an output stands behind code that is run."""
    previous: Block | None = None
    for block in read_blocks(page):
        assert block.language in LANGUAGES, f"{block.place()}: {block.language!r} is none of {sorted(LANGUAGES)}"
        if block.language == "text":
            assert block.reason, f"{block.place()}: printed output is a block of `output`; others say what they are"
        if block.language == "output" and not block.reason:
            assert previous is not None, f"{block.place()}: no code stands before this output"
            assert previous.is_code, f"{block.place()}: no code stands before this output"
            assert not previous.reason, f"{block.place()}: the code before this output is not run"
        previous = block


def test_all_pages_together_are_short() -> None:
    """Words have a letter or a digit; code, and rules and bars of tables, have none."""
    pages = [page for page in PAGES if page.stem not in {"CONTRIBUTING", *GENERATED}]
    prose = [CODE.sub("", page.read_text(encoding="utf-8")) for page in pages]
    assert sum(bool(re.search(r"\w", word)) for text in prose for word in text.split()) <= MAX_WORDS


def test_what_is_not_run_stands_on_a_page() -> None:
    lines = [line for page in PAGES for block in read_blocks(page) for _, line in commands(block)]
    assert [beginning for beginning in NOT_RUN if not any(line.startswith(beginning) for line in lines)] == []


def page_of(folder: Path, text: str) -> Path:
    page = folder / "page.md"
    page.write_text(text, encoding="utf-8")
    return page


def read(page: Path) -> None:
    reader = Reader(page.parent)
    for block in read_blocks(page):
        reader.read(block)


def test_names_last_from_block_to_block_and_numbers_are_compared_by_tolerance(tmp_path: Path) -> None:
    read(page_of(tmp_path, "```python\na = 101.0\n```\n\n```python\nprint('a:', a)\n```\n\n```output\na: 100.0\n```\n"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("One.\n\n```python\na = 1\nb = a / 0\n```\n", r"page.md:5: ZeroDivisionError"),
        (
            "```sh\n# first\nlayflat machine show nobody\n```\n",
            r"page.md:3: `layflat machine show nobody`: layflat: .*nobody",
        ),
        ("```python\nprint('a\\nb 3')\n```\n\n```output\na\nb 4\n```\n", r"page.md:7: the page shows 'b 4', .* 'b 3'"),
        ("```python\nprint('a\\nb')\n```\n\n```output\na\n```\n", r"page.md:6: the code prints more: 'b'"),
        ("```sh\nlayflat panel\n```\n\n```output\na\n```\n", r"page.md:5: no code that is run"),
        ("<!-- not run: why -->\n```python\nb\n```\n\n```output\na\n```\n", r"page.md:6: no code that is run"),
    ],
)
def test_a_block_that_fails_is_told_with_page_and_line(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(PageError, match=message):
        read(page_of(tmp_path, text))


def test_a_comment_leaves_a_block_out(tmp_path: Path) -> None:
    read(
        page_of(
            tmp_path,
            "<!-- not run: no camera here -->\n```python\nb\n```\n\n<!-- not compared: so -->\n\n```output\n1\n```\n",
        )
    )


def test_a_description_that_is_wrong_is_told_with_page_and_line(tmp_path: Path) -> None:
    page = page_of(tmp_path, '```toml\n# mine.toml\nextends = "paper-arm"\nnobody = 1\n```\n\n```toml\na b\n```\n')
    read(page)
    first, second = check_descriptions(read_blocks(page), tmp_path)
    assert "page.md:1: " in first
    assert "nobody" in first
    assert "page.md:7: " in second
