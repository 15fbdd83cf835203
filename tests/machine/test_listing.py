import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from layflat.machine import load, names
from layflat.machine.listing import list_values, schema_text, to_toml
from layflat.machine.loader import BUILT_IN, tables


@pytest.mark.parametrize("name", names())
def test_a_printed_description_loads_as_the_same_machine(name: str, tmp_path: Path) -> None:
    path = tmp_path / "copy.toml"
    path.write_text(to_toml(*tables(name)), encoding="utf-8")
    assert load(path) == load(name)
    assert load(path).provenance == load(name).provenance


def test_listing_shows_values_as_written_with_their_source() -> None:
    lines = {line.path: line for line in list_values(*tables("paper-arm"))}
    width = lines["joint.large.hose.width"]
    assert (width.text, width.source, width.note) == ("160 mm", "paper", "section 2.3")


def test_listing_leaves_out_joints_that_the_arm_does_not_use() -> None:
    assert not any(line.path.startswith("joint.large") for line in list_values(*tables("paper-small-joint")))


@pytest.fixture(scope="module")
def schema() -> jsonschema.Draft202012Validator:
    made = json.loads(schema_text())
    jsonschema.Draft202012Validator.check_schema(made)
    return jsonschema.Draft202012Validator(made)


@pytest.mark.parametrize("name", names())
def test_built_in_files_satisfy_the_schema(name: str, schema: jsonschema.Draft202012Validator) -> None:
    schema.validate(tomllib.loads((BUILT_IN / f"{name}.toml").read_text(encoding="utf-8")))


def test_schema_refuses_unknown_keys_and_bare_numbers(schema: jsonschema.Draft202012Validator) -> None:
    assert not schema.is_valid({"supply": {"pressure": "4 bar"}})
    assert not schema.is_valid({"joint": {"a": {"hose": {"width": 160}}}})
    assert schema.is_valid({"joint": {"a": {"hose": {"width": "160 mm"}}}})
