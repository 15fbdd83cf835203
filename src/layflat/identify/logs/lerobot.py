"""LeRobot data set out of logs of rigs and benches, and of simulated runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from layflat.errors import InputError
from layflat.identify.logs.episodes import ACTION_SIGNALS, EPISODE_SPLITS, EpisodeFrames, LogSource, read_episodes
from layflat.identify.logs.mapping import LogMapping
from layflat.lerobot import EpisodeWriter, WrittenDataset
from layflat.lerobot.writer import check_fps, check_target, check_task
from layflat.machine import Machine, load

ROBOT_TYPE = "layflat"  # of a data set whose machine is not known


def write_lerobot(
    logs: LogSource | Sequence[LogSource],
    folder: str | Path,
    *,
    task: str | Sequence[str],
    fps: int | None = None,
    action: Literal["demand", "voltage"] = "demand",
    episodes: Literal["log", "move"] = "log",
    mapping: LogMapping | str | Path | None = None,
    machine: Machine | str | None = None,
) -> WrittenDataset:
    """Write logs as a LeRobot data set, version 3.0.

    `observation.state` has what the sensors measured: joint angles (rad) and pressures (Pa). Logs are read one after
    the other, and the folder is there once all are written.

    Args:
        logs: files, data sets (runs, or logs of `read_log`), or tables of `read_table`.
        folder: new or empty folder.
        task: what the machine does, in words: one text, or one for each log.
        fps: frames a second, a whole number up to the rate of the logs; default: the rate of the first.
        action: "demand" (rad) or "voltage" (V) of each joint.
        episodes: "log" for an episode a log, cut where a signal has a gap; "move" for one from each move of the demand
            to the next.
        mapping: mapping of the columns, or its file; not needed where they have layflat's own names.
        machine: machine, its name or its file: its joints, in its order; its name is the data set's `robot_type`.

    Returns:
        The folder, and the numbers of episodes, frames and tasks.

    Raises:
        InputError: a log, the mapping or an argument is wrong, or logs have other joints or signals than the first.
        MissingExtraError: pyarrow is not installed.
        OutputError: the folder is not empty, or can't be written.

    Example:
        >>> import layflat as lf
        >>> from tempfile import TemporaryDirectory
        >>> run = lf.rollout("paper-arm", "10 deg", duration="0.5 s")
        >>> with TemporaryDirectory() as folder:
        ...     written = lf.write_lerobot(run, folder + "/moves", task="move to 10 degrees", fps=50)
        >>> written.episodes, written.frames
        (1, 26)
    """
    sources = list(logs) if isinstance(logs, Sequence) and not isinstance(logs, str) else [logs]
    tasks = _tasks_of_logs(task, len(sources))
    for name, value, choices in (("action", action, ACTION_SIGNALS), ("episodes", episodes, EPISODE_SPLITS)):
        if value not in choices:
            raise InputError(f"{value!r} is unknown", where=name, right=f"give {' or '.join(map(repr, choices))}")
    rate = check_fps(fps) if fps is not None else None
    described = load(machine) if isinstance(machine, str) else machine
    joints = list(described.joints) if described is not None else None
    robot_type = described.name if described is not None else ROBOT_TYPE

    def read(source: LogSource, fps: int | None) -> EpisodeFrames:
        """Return the episodes of a log."""
        return read_episodes(source, fps=fps, action=action, split=episodes, mapping=mapping, joints=joints)

    check_target(Path(folder))
    frames = read(sources[0], rate)
    state, command, first_name = frames.state, frames.action, frames.name
    vectors = {"observation.state": state, "action": command}
    with EpisodeWriter(Path(folder), frames.fps, robot_type, vectors) as writer:
        for number, (source, text) in enumerate(zip(sources, tasks, strict=True)):
            if number > 0:
                frames = read(source, writer.fps)
                _check_same_names(frames, (*state.names, *command.names), first_name)
            for values in frames.episodes():
                writer.add_episode(text, values)
    return writer.summary


def _tasks_of_logs(task: str | Sequence[str], count: int) -> list[str]:
    """Return the task of each log; raise InputError for none, an empty one, or another number of them."""
    if count == 0:
        raise InputError("are none", where="logs", right="give one or more")
    tasks = [task] * count if isinstance(task, str) else list(task)
    tasks = tasks * count if len(tasks) == 1 else tasks
    if len(tasks) != count:
        right = "give one for all logs, or one for each"
        raise InputError(f"{len(tasks)} are not as many as {count} logs", where="task", right=right)
    return [check_task(each) for each in tasks]


def _check_same_names(frames: EpisodeFrames, expected: tuple[str, ...], first: str) -> None:
    """Raise InputError for a log with other joints or signals than the first log, whose names are `expected`."""
    names = (*frames.state.names, *frames.action.names)
    if names == expected:
        return
    what = f"has {', '.join(names)}, and {first} has {', '.join(expected)}"
    for name in (*names, *expected):
        if (name in names) != (name in expected):
            what = f"{'has' if name in names else 'lacks'} {name}, unlike {first}"
            break
    raise InputError(what, where=frames.name, right="write logs of one machine with the same sensors")
