"""Metadata of the project: how it is cited, and by which words it is found."""

import datetime
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from layflat import __version__

ROOT = Path(__file__).parents[1]
TEXT = {"type": "string", "minLength": 1}
NAMED = {"type": "object", "required": ["name"], "additionalProperties": False, "properties": {"name": TEXT}}
PEOPLE = {"type": "array", "minItems": 1, "items": NAMED}
KEYWORDS = {"type": "array", "uniqueItems": True, "minItems": 1, "items": TEXT}
REFERENCE = {
    "type": "object",
    "required": ["type", "title", "authors"],
    "additionalProperties": False,
    "properties": {"type": {"const": "article"}, "title": TEXT, "authors": PEOPLE, "notes": TEXT},
}
CITATION = {
    "type": "object",
    "required": ["cff-version", "message", "title", "authors"],
    "additionalProperties": False,
    "properties": {
        "cff-version": {"const": "1.2.0"},
        "message": TEXT,
        "title": TEXT,
        "abstract": TEXT,
        "type": {"const": "software"},
        "authors": PEOPLE,
        "version": TEXT,
        "license": {"const": "MIT"},
        "keywords": KEYWORDS,
        "references": {"type": "array", "minItems": 1, "items": REFERENCE},
    },
}
"""The keys of the schema 1.2.0 of the Citation File Format that the file uses; another one has to be added here."""


@pytest.fixture(scope="module")
def citation() -> Any:
    yaml = pytest.importorskip("yaml", reason="needs the extra `hyddown`")
    return yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def project() -> dict[str, Any]:
    found: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return found


def test_the_citation_is_valid(citation: Any) -> None:
    jsonschema.Draft7Validator(CITATION).validate(citation)
    assert not any(isinstance(value, datetime.date) for value in citation.values())


def test_the_citation_is_of_this_version_and_names_the_paper(citation: Any, project: dict[str, Any]) -> None:
    assert citation["version"] == __version__
    assert citation["license"] == project["license"]
    assert citation["keywords"] == project["keywords"]
    assert [one["title"] for one in citation["references"]] == [
        "An improved flexible pneumatic joint for horticultural robots"
    ]


def test_classifiers_are_known(project: dict[str, Any]) -> None:
    known = pytest.importorskip("trove_classifiers").classifiers
    assert set(project["classifiers"]) <= known
    assert project["classifiers"] == sorted(project["classifiers"], key=lambda name: (name.split(" :: ")[0], name))


def test_the_logo_is_what_its_program_draws() -> None:
    from docs.logo import FOLDER, logo

    assert (FOLDER / "logo.svg").read_text(encoding="utf-8") == logo()
