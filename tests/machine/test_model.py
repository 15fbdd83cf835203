from layflat.machine import Machine, changed, load

ARM = load("paper-arm")


def test_a_machine_comes_back_from_json_exactly() -> None:
    assert Machine.model_validate_json(ARM.model_dump_json()) == ARM


def test_machines_differ_by_their_values_alone() -> None:
    assert changed(ARM, "arm.payload", 1.5) == ARM
    assert changed(ARM, "arm.payload", 1.6) != ARM


def test_origin_is_the_file_or_the_name() -> None:
    assert ARM.origin == "paper-arm"
    assert Machine.model_validate_json(ARM.model_dump_json()).origin == "paper-arm"
