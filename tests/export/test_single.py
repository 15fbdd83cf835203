"""Portable code in single precision does each operation in single precision."""

import ctypes
from typing import Any

import numpy as np
import pytest

from layflat.errors import CompilerError
from layflat.export.single import in_single_precision
from layflat.jit import objects

HEAD = "define void @f(ptr %in, ptr %out) {\n  %single = load float, ptr %in\n  %x = fpext float %single to double\n"
TAIL = "  %less = fptrunc double %y to float\n  store float %less, ptr %out\n  ret void\n}\n"


def computed(body: str, value: float) -> np.float32:
    """Return the result of code that computes %y from %x, after its change to single precision."""
    text = in_single_precision(HEAD + body + TAIL + "declare double @llvm.sqrt.f64(double)\n")
    loaded: Any = objects.load(objects.machine_code(text, ("f",), objects.host(), ordered=False), "f")
    function = ctypes.cast(loaded, ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p))
    numbers = np.array([value, 0.0], np.float32)
    function(numbers.ctypes.data, numbers.ctypes.data + 4)
    return np.float32(numbers[1])


def test_each_operation_rounds() -> None:
    value = np.float32(1.1)
    body = "  %a = fmul double %x, 0x3FB999999999999A\n  %y = fadd double %a, 1.000000e+08\n"
    assert computed(body, 1.1) == value * np.float32(0.1) + np.float32(1e8)


def test_functions_of_llvm_are_those_of_single_precision() -> None:
    assert computed("  %y = call double @llvm.sqrt.f64(double %x)\n", 2.0) == np.sqrt(np.float32(2.0))


@pytest.mark.parametrize("value", [0.4, 2.6, -3.7, 100.2])
def test_a_sum_that_rounds_to_whole_numbers_still_does(value: float) -> None:
    """As in `wrap_angle`: 1.5 over the precision, which the compiler has folded."""
    body = "  %a = fadd double %x, 0x4338000000000000\n  %y = fadd double %a, 0xC338000000000000\n"
    assert computed(body, value) == np.rint(np.float32(value))


def test_memory_keeps_its_layout() -> None:
    body = """  %s = alloca [2 x double]
  store double %x, ptr %s
  %second = getelementptr i8, ptr %s, i64 8
  store double 1.000000e+00, ptr %second
  %i = fptosi double %x to i64
  %p = getelementptr [2 x double], ptr %s, i64 0, i64 %i
  %y = load double, ptr %p
"""
    assert [computed(body, value) for value in (0.25, 1.0)] == [0.25, 1.0]


def test_lanes_in_memory_keep_the_places_of_their_numbers() -> None:
    body = """  %s = alloca [3 x double]
  %second = getelementptr i8, ptr %s, i64 8
  %a = insertelement <2 x double> <double 3.000000e+00, double 5.000000e+00>, double %x, i64 0
  store <2 x double> %a, ptr %second, align 8
  store double 2.000000e+00, ptr %s
  %1 = load <2 x double>, ptr %s, align 8, !tbaa !0
  %b = extractelement <2 x double> %1, i64 0
  %c = extractelement <2 x double> %1, i64 1
  %y = fmul double %b, %c
"""
    assert computed(body.replace(", !tbaa !0", ""), 1.25) == 2.5
    third = body.replace("load <2 x double>, ptr %s, align 8, !tbaa !0", "load <2 x double>, ptr %second")
    assert computed(third, 1.25) == 6.25


def test_tuples_in_memory_are_refused() -> None:
    with pytest.raises(CompilerError, match="side by side"):
        in_single_precision(HEAD + "  store [2 x double] zeroinitializer, ptr %out\n" + TAIL)
