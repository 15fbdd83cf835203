"""The control laws that can be tuned, by name."""

from layflat.errors import MachineError
from layflat.machine import Machine
from layflat.tune import papers_law, tracking_law
from layflat.tune.knobs import Tunable

TUNABLES = {"paper": papers_law.TUNABLE, "tracking": tracking_law.TUNABLE}


def tunable(machine: Machine) -> Tunable:
    """Return what of a machine's control law is tuned.

    Raises:
        MachineError: it has no controller, or one with nothing to tune.
    """
    if machine.valve is None or machine.controller is None:
        right = "add the parts `valve` and `controller`; `layflat show paper-arm` has both"
        raise MachineError("has no controller to be tuned", where=machine.origin, right=right)
    name = machine.control_law.name
    if name not in TUNABLES:
        raise MachineError(
            f"nothing is known of what could be tuned in {name!r}",
            where=f"{machine.origin}: controller.kind",
            right=f"give one of {', '.join(TUNABLES)}",
        )
    return TUNABLES[name]
