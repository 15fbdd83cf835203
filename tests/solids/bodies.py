"""Solids as build123d has them, which measures the kernel's shapes in ways of its own."""

from __future__ import annotations

from typing import Any

import pytest


def body_of(solid: Any) -> Any:
    return pytest.importorskip("build123d").Solid(solid)
