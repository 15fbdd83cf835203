import json
from typing import Any

import pytest

from layflat.errors import MachineError
from layflat.machine import Machine, changed, load
from layflat.machine.model import restore

ARM = load("paper-arm")


def test_a_machine_comes_back_from_json_exactly() -> None:
    assert Machine.model_validate_json(ARM.model_dump_json()) == ARM


def test_machines_differ_by_their_values_alone() -> None:
    assert changed(ARM, "arm.payload", 1.5) == ARM
    assert changed(ARM, "arm.payload", 1.6) != ARM


def test_origin_is_the_file_or_the_name() -> None:
    assert ARM.origin == "paper-arm"
    assert Machine.model_validate_json(ARM.model_dump_json()).origin == "paper-arm"


def test_a_machine_without_controller_has_the_papers_cycle() -> None:
    assert changed(load("paper-arm"), "controller.cycle", 0.004).cycle == 0.004
    assert load("paper-arm").model_copy(update={"controller": None}).cycle == 0.005


@pytest.mark.parametrize(
    ("text", "message"),
    [
        *((text, "machine: is not JSON") for text in ("", "nope", "{", "[" * 100_000, "1" * 5000)),
        *((text, "machine: is no table; give the JSON text of a machine") for text in ("[1]", "3", "null", '"x"')),
        ("{}", "machine: name: is missing"),
    ],
    ids=lambda text: text[:12],
)
def test_a_text_of_no_machine_is_refused_in_one_line(text: str, message: str) -> None:
    with pytest.raises(MachineError) as caught:
        restore(text)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("key", [key for key in type(ARM).model_fields if key not in {"name", "title"}])
def test_a_table_of_another_type_is_refused(key: str) -> None:
    whole = json.loads(ARM.model_dump_json())
    values: list[Any] = [3, [3], "x", {"kind": [1]}, {"kind": {}}]
    for value in values:
        if (key, value) != ("kinds", "x"):
            with pytest.raises(MachineError, match=f"machine: {key}"):
                restore(json.dumps(whole | {key: value}))
