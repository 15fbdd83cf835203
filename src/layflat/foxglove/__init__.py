"""Runs, logs and rigs in Foxglove: files that it opens, and servers to which it connects.

The way of a value: a run or a log is a data set, whose arrays become a `SignalLog` (`signals.py`); its rows, or those
of a rig that runs (`rig.py`), become messages (`topics.py`) and an arm in space (`arm.py`), which go to an MCAP file
(`file.py`) or to a WebSocket server (`server.py`), which plays them by a clock that viewers control (`playback.py`).

Example:
    >>> import layflat as lf
    >>> run = lf.rollout("paper-arm", {"large": "20 deg"}, duration="0.5 s")
    >>> lf.foxglove.write_mcap(run, "run.mcap").stat().st_size > 10_000
    True
"""

from typing import TYPE_CHECKING

from layflat.lazy import lazy_getattr

if TYPE_CHECKING:
    from layflat.foxglove.file import write_mcap
    from layflat.foxglove.playback import Playback
    from layflat.foxglove.rig import RigServer

__all__ = ["Playback", "RigServer", "write_mcap"]

__getattr__ = lazy_getattr(
    __name__,
    {
        "Playback": "layflat.foxglove.playback:Playback",
        "RigServer": "layflat.foxglove.rig:RigServer",
        "write_mcap": "layflat.foxglove.file:write_mcap",
    },
)
