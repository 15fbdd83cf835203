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


def test_a_machine_without_controller_has_the_papers_cycle() -> None:
    assert changed(load("paper-arm"), "controller.cycle", 0.004).cycle == 0.004
    assert load("paper-arm").model_copy(update={"controller": None}).cycle == 0.005
