"""Parts of the fitted logs that are left out in turn: whole logs, or blocks of time of the only one."""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from layflat.identify.model import Flags, Model, Output

MAX_FOLDS = 3  # more logs are left out several at a time: a third, as new logs differ from all that are fitted
BLOCKS = 3  # into which the only fitted log is divided; the first is always fitted, as runs begin with it


@dataclass(frozen=True)
class Fold:
    """A model with some samples left out, and which these are."""

    name: str  # of the logs or the block
    model: Model  # the same unknowns and outputs; `fitted` without what is left out
    left_out: tuple[Flags, ...]  # of each output


def split_folds(model: Model) -> list[Fold]:
    """Leave out each fitted log of a model in turn; of a single one, each block of its time but the first."""
    logs = list(dict.fromkeys(output.log for output in model.outputs if output.fitted.any()))
    if len(logs) > 1:
        groups = [logs[i::MAX_FOLDS] for i in range(min(MAX_FOLDS, len(logs)))]
        return [_fold(model, ", ".join(group), partial(_of_logs, group)) for group in groups]
    return [
        _fold(model, f"{logs[0]}, part {block + 1} of {BLOCKS}", partial(_of_block, block))
        for block in range(1, BLOCKS)
    ]


def _fold(model: Model, name: str, chosen: Callable[[Output], Flags]) -> Fold:
    left_out = tuple(chosen(output) & output.fitted for output in model.outputs)
    outputs = tuple(
        replace(output, fitted=output.fitted & ~out) for output, out in zip(model.outputs, left_out, strict=True)
    )
    return Fold(name, with_outputs(model, outputs), left_out)


def with_outputs(model: Model, outputs: tuple[Output, ...]) -> Model:
    """Return a copy of a model that fits other samples of the same outputs."""
    other = copy(model)
    other.outputs = outputs
    for name in ("used", "measured"):
        other.__dict__.pop(name, None)
    return other


def _of_logs(logs: list[str], output: Output) -> Flags:
    return np.full(len(output.time), output.log in logs)


def _of_block(block: int, output: Output) -> Flags:
    time = output.time[output.fitted]
    edges = time[0] + (time[-1] - time[0]) * np.arange(BLOCKS + 1) / BLOCKS if len(time) else np.zeros(BLOCKS + 1)
    last = block == BLOCKS - 1
    return np.asarray((output.time >= edges[block]) & (last | (output.time < edges[block + 1])))
