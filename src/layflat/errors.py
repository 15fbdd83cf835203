"""The one tree of exceptions: catch `LayflatError` to catch everything that layflat raises on purpose."""

from collections.abc import Sequence
from pathlib import Path


class LayflatError(Exception):
    """Base of all errors; its message is one line that a user can act on."""


class InputError(LayflatError):
    """Something that the user gave is wrong: a file, a key, a value, an option.

    Args:
        what: what is wrong, with the offending value.
        where: the file or option it stands in, and the key inside it.
        right: what would be right, with an example.
    """

    def __init__(self, what: str, *, where: str = "", right: str = "") -> None:
        self.what, self.where, self.right = what, where, right
        text = f"{where}: {what}" if where else what
        super().__init__(f"{text}; {right}" if right else text)


class MissingExtraError(InputError):
    """A package that an extra brings is not installed.

    Args:
        extra: the extra.
        packages: what is missing, as pip knows it.
        where: what needs it.
        reason: why a package that is there can't be imported.
        repair: the command that mends it, where to install the extra again does not.
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
    """A machine's description is wrong or describes something that can't exist."""


class CellError(InputError):
    """A packing cell's description is wrong, describes something that can't be, or its scene can't be made."""


class NoDrawingError(LayflatError):
    """No picture can be made here: a library that draws is missing."""


class DesignError(InputError):
    """No joint, cam or strap can be made to what was asked."""


class OutputError(InputError):
    """A result can't be written where it was asked for."""


class PictureError(InputError):
    """A picture can't be used: black, blurred, of another size, or without what should be in it."""


class CameraError(InputError):
    """The camera is not where its calibration says, or can't be calibrated with what was given."""


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
    """The rig's supervisor holds the joints, or has let out the air; the message says for which fault."""


class UnreachedError(LayflatError):
    """A search did not find what brings an arm to its goal."""


class DivergedError(LayflatError):
    """A run left the range in which the model is valid.

    Args:
        time: when, s.
        joint: the joint's name.
        run: the run's data up to then, where there are any.
        cause: why, where that is known.
    """

    def __init__(self, time: float, joint: str, run: object = None, cause: str = "") -> None:
        self.time, self.joint, self.run = time, joint, run
        kept = "" if run is None else "the data up to there are kept; "
        advice = cause or "a shorter step (--step), a smaller valve or lower gains may help"
        super().__init__(f"the run diverged at t = {time:.4f} s in joint {joint!r}; {kept}{advice}")
