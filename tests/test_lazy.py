"""NumPy, and other modules, that are imported when they are first used."""

import subprocess
import sys

import numpy as np
import pytest

from layflat.lazy import LazyModule, numpy


def test_a_module_is_imported_by_the_first_use_of_a_name() -> None:
    code = (
        "import sys; from layflat.lazy import LazyModule; m = LazyModule('colorsys'); b = 'colorsys' in sys.modules\n"
        "print(b, m.rgb_to_hsv(1, 1, 1), 'colorsys' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False (0.0, 0.0, 1) True\n"


def test_its_names_are_those_of_the_module() -> None:
    assert numpy.array is np.array
    assert numpy.polynomial.polynomial.polyfit is np.polynomial.polynomial.polyfit
    assert "array" in vars(numpy), "kept, so that the next use costs nothing"
    with pytest.raises(AttributeError, match="nothing_of_this_name"):
        LazyModule("numpy").nothing_of_this_name  # noqa: B018
