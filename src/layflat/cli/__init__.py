"""The command line: the one place that puts the parts together."""

from __future__ import annotations

import sys

import typer

from layflat.cli import (
    arm_model,
    cells,
    describe,
    design,
    identify,
    log,
    pack,
    recorded,
    reproduce,
    rig_check,
    rig_faults,
    rig_run,
    rig_serve,
    simulate,
    study,
    tune,
)
from layflat.cli.app import app
from layflat.errors import LayflatError

__all__ = [
    "app",
    "arm_model",
    "cells",
    "describe",
    "design",
    "identify",
    "log",
    "main",
    "pack",
    "recorded",
    "reproduce",
    "rig_check",
    "rig_faults",
    "rig_run",
    "rig_serve",
    "simulate",
    "study",
    "tune",
]


def main() -> None:
    """Run a command; a mistake of the user's gives one line on stderr and exit status 2."""
    try:
        status = app(standalone_mode=False)
    except LayflatError as error:
        _fail(str(error))
    except typer.TyperException as error:
        _fail(f"{error.format_message()} (`layflat --help` shows how)")
    except (typer.Abort, KeyboardInterrupt):
        _fail("stopped", status=130)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(0)
    sys.exit(status if isinstance(status, int) else 0)


def _fail(text: str, status: int = 2) -> None:
    print(f"layflat: {' '.join(text.split())}", file=sys.stderr)  # noqa: T201
    sys.exit(status)
