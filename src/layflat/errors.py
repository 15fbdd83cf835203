"""The one tree of exceptions: catch `LayflatError` to catch everything that layflat raises on purpose."""

from collections.abc import Sequence
from pathlib import Path

__all__ = [
    "CameraError", "CellError", "CompilerError", "DesignError", "DivergedError", "InputError", "KindError",
    "LayflatError", "MachineError", "MissingExtraError", "NoDrawingError", "OutputError", "PictureError",
    "RigStoppedError", "StoppedError", "UnreachedError",
]  # fmt: skip


class LayflatError(Exception):
    """Base of all errors; its message is one line that a user can act on.

    Example:
        >>> import layflat as lf
        >>> try:
        ...     lf.load("paper-harm")
        ... except lf.LayflatError as error:
        ...     print(error)
        paper-harm: no such machine...did you mean 'paper-arm'?
    """


class InputError(LayflatError):
    """An input of the user is wrong: a file, a key, a value, an argument.

    Args:
        what: what is wrong, with the offending value.
        where: the file or argument it stands in, and the key inside it.
        right: what would be right, with an example; it names arguments in backquotes, as `seed` or `to='hand'`.

    Example:
        >>> import layflat as lf
        >>> lf.rollout("paper-arm", "40")
        Traceback (most recent call last):
        layflat.errors.InputError: demand: '40' is a bare number; give an angle such as "120 deg"
    """

    def __init__(self, what: str, *, where: str = "", right: str = "") -> None:
        self.what, self.where, self.right = what, where, right
        text = f"{where}: {what}" if where else what
        super().__init__(f"{text}; {right}" if right else text)


class MissingExtraError(InputError):
    """A package of an extra is not installed, or can't be imported.

    Args:
        extra: name of the extra.
        packages: missing packages, by their names for pip.
        where: the command, option or file that needs them.
        reason: the error of an installed package that can't be imported.
        repair: the command that repairs it, where installing the extra again does not.

    Example:
        >>> import layflat as lf
        >>> lf.MissingExtraError("tune", ["cma"], where="tune_controller")
        MissingExtraError("tune_controller: needs cma, not installed; install it: pip install 'layflat[tune]'")
    """

    def __init__(
        self, extra: str, packages: Sequence[str], where: str = "", reason: str = "", repair: str = ""
    ) -> None:
        self.extra = extra
        state = f"can't be imported ({reason})" if reason else "not installed"
        super().__init__(
            f"needs {' and '.join(packages)}, {state}",
            where=where,
            right=f"repair it: {repair}" if repair else f"install it: pip install 'layflat[{extra}]'",
        )


class MachineError(InputError):
    """A machine's description is wrong or describes something that can't exist.

    Example:
        >>> import layflat as lf
        >>> lf.design_joint("paper-arm", "elbow")
        Traceback (most recent call last):
        layflat.errors.MachineError: paper-arm: unknown joint 'elbow'; name one of large, small
    """


class CellError(InputError):
    """A packing cell's description is wrong, describes something that can't be, or its scene can't be made."""


class NoDrawingError(LayflatError):
    """No picture can be made here: a library that draws is missing."""


class DesignError(InputError):
    """No joint, cam or strap meets the demands.

    Example:
        >>> import layflat as lf
        >>> lf.size_joint(lf.SizingRequest(torque="500 N m", stroke="120 deg", supply="1 bar"))
        Traceback (most recent call last):
        layflat.errors.DesignError: size: the widest hose sold, 310 mm, can't give 500 N m over 120 deg at 1 bar; ...
    """


class OutputError(InputError):
    """A result can't be written to the requested place.

    Example:
        >>> import layflat as lf
        >>> lf.save(lf.load("paper-arm"), ".")
        Traceback (most recent call last):
        layflat.errors.OutputError: .: is a folder; give the name of a file
    """


class PictureError(InputError):
    """A picture can't be used: black, blurred, of another size, or without what should be in it."""


class CameraError(InputError):
    """The camera is not where its calibration says, or can't be calibrated with these images."""


class KindError(InputError):
    """A kind of control law, valve, hysteresis or arm is unknown, not whole, or its law fails."""


class CompilerError(LayflatError):
    """The installed compiler (numba, llvmlite) is not one that layflat knows."""


class StoppedError(LayflatError):
    """The user stopped the work (Ctrl-C): the command ends with exit status 130.

    Raise it after what was done has been written and marked as partial.

    Args:
        done: how far the work was, such as "12 of 40 runs".
        kept: where partial results are.
    """

    def __init__(self, done: str = "", kept: Path | str = "") -> None:
        self.done, self.kept = done, kept
        after = f" after {done}" if done else ""
        super().__init__(f"stopped{after}" + (f"; partial results are in {kept}" if kept else ""))


class RigStoppedError(LayflatError):
    """The rig's supervisor holds the joints, or has vented them; the message says for which fault."""


class UnreachedError(LayflatError):
    """A search did not find a motion that reaches the goal."""


class DivergedError(LayflatError):
    """A simulation run left the range in which the model is valid.

    Args:
        time: of the divergence, s.
        joint: the joint's name.
        run: the data up to then, if any.
        cause: reason or advice that ends the message; default: advice on step, valve and gains.

    Example:
        >>> import layflat as lf
        >>> error = lf.DivergedError(0.25, "small", cause="a shorter step may help")
        >>> print(error, error.joint)
        the run diverged at t = 0.2500 s in joint 'small'; a shorter step may help small
    """

    def __init__(self, time: float, joint: str, run: object = None, cause: str = "") -> None:
        self.time, self.joint, self.run = time, joint, run
        kept = "" if run is None else "the data up to there are kept; "
        advice = cause or "a shorter step, a smaller valve or lower gains may help"
        super().__init__(f"the run diverged at t = {time:.4f} s in joint {joint!r}; {kept}{advice}")
