import pytest

from tests.pages.server.serving import Served


@pytest.mark.parametrize(
    ("path", "status"), [("/", 200), ("/favicon.ico", 200), ("/not-there", 404), ("/?token=wrong", 403), ("/..", 400)]
)
def test_every_answer_is_protected(served: Served, path: str, status: int) -> None:
    answer = served.ask(path, served.allowed())
    assert answer.status == status
    policy = answer.headers["Content-Security-Policy"]
    for rule in ("default-src 'self'", "object-src 'none'", "frame-ancestors 'none'", "form-action 'self'"):
        assert rule in policy
    assert "http" not in policy
    assert answer.headers["X-Content-Type-Options"] == "nosniff"
    assert answer.headers["X-Frame-Options"] == "DENY"
    assert answer.headers.get_all("Referrer-Policy") == ["no-referrer"]
    assert answer.headers["Cross-Origin-Opener-Policy"] == "same-origin"
    assert answer.headers["Cross-Origin-Resource-Policy"] == "same-origin"


def test_a_refusal_is_a_page_with_words(served: Served) -> None:
    answer = served.ask("/")
    assert answer.headers["Content-Type"] == "text/html; charset=utf-8"
    assert answer.headers["Cache-Control"] == "no-store"
    assert answer.text.startswith('<!doctype html>\n<html lang="en-US">')
    assert "This page needs the link that layflat printed when it started" in answer.text


def test_the_program_that_serves_is_not_named(served: Served) -> None:
    assert served.ask("/", served.allowed()).headers["Server"] is None
