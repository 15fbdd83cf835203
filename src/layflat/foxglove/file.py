"""A run or a log as an MCAP file that Foxglove opens."""

from io import BytesIO
from pathlib import Path
from typing import Any

from layflat import extras
from layflat._version import __version__
from layflat.arrays import Dataset
from layflat.files import whole_file
from layflat.foxglove.signals import SignalLog, read_signals
from layflat.foxglove.topics import ArmTopics
from layflat.machine import Machine


def write_mcap(data: Dataset, path: str | Path, *, machine: str | Path | Machine | None = None) -> Path:
    """Write a run or a log as an MCAP file with the topics of `layflat.foxglove.topics`.

    Args:
        data: run of `rollout`, `open_run` or a rig, or log of `read_log`.
        path: path of the file, NAME.mcap.
        machine: machine whose arm is shown; default: the one in `data`.

    Returns:
        The path.

    Raises:
        InputError: `data` has no numbers over time, or other joints than the machine.
        MissingExtraError: Foxglove's SDK is not installed.
        OutputError: the file can't be written.

    Example:
        >>> import layflat as lf
        >>> run = lf.rollout("paper-arm", {"large": "20 deg"}, duration="0.5 s")
        >>> lf.foxglove.write_mcap(run, "run.mcap").name
        'run.mcap'
    """
    log, path = read_signals(data, machine), Path(path)
    sdk = extras.import_extra("foxglove", "foxglove", where=str(path))
    context = sdk.Context()
    topics = topics_of(context, log)
    content = BytesIO()  # in memory: where a disk is full, the SDK prints a line for each message, or panics
    with sdk.open_mcap(content, context=context) as file:
        file.write_metadata("layflat", {"layflat_version": __version__, "name": log.name})
        _log_all(topics, log)
    with whole_file(path) as temporary:
        temporary.write_bytes(content.getvalue())
    return path


def topics_of(context: Any, log: SignalLog) -> ArmTopics:
    """Return the topics of a run or log in a context of the SDK; raise as `ArmTopics` does."""
    by_joint = {name: log.meanings[name] for name in log.signals if log.is_by_joint(name)}
    shared = {name: log.meanings[name] for name in log.signals if name not in by_joint}
    return ArmTopics(context, log.joints, by_joint, shared, log.parts, log.machine)


def _log_all(topics: ArmTopics, log: SignalLog) -> None:
    """Log all rows and events in the order of their stamps, and the scene at the first row."""
    events = iter([*sorted(log.events), None])
    event = next(events)
    for index, stamp in enumerate(log.stamps.tolist()):
        while event is not None and event[0] <= stamp:
            topics.log_event(*event)
            event = next(events)
        topics.log_row(stamp, log.row(index))
        if index == 0:
            topics.log_scene(stamp)
    while event is not None:
        topics.log_event(*event)
        event = next(events)
