"""The whole check of a rig."""

from collections.abc import Callable

from layflat.machine import Machine
from layflat.rig.check.open_loop import CheckResult, OpenLoopRig
from layflat.rig.check.signs import try_signs
from layflat.rig.check.still import look
from layflat.rig.clock import Clock
from layflat.rig.driver import Driver


def check_rig(
    machine: Machine, driver: Driver, clock: Clock, *, air: bool = False, tell: Callable[[str], object] = str
) -> list[CheckResult]:
    """Look at a rig without air, and if that finds nothing wrong and it is asked for, with air: every joint moves.

    The driver comes unconfigured and is finalized afterwards; `tell` is called with what is being done.

    Raises:
        DriverError: nothing that fits is there.
        InputError: it has other joints, voltages or times than the machine.
    """
    try:
        able = driver.configure()
        able.check(machine)
        volts = f"{able.voltage_low:g} to {able.voltage_high:g} V, closed at {able.centre_voltage:g} V"
        findings = [CheckResult("device", f"{able.joints} joints, {volts}, as described")]
        bench = OpenLoopRig(machine, driver, clock)
        tell("looking on")
        findings += look(bench)
        if air and all(one.passed for one in findings):
            findings += try_signs(bench, tell)
        elif air:
            findings.append(CheckResult("air", "not tried", "see to the failed checks first"))
        return findings
    finally:
        driver.finalize()
