"""Lanes for the compiler: importing this package registers their types, instructions, slots, boxing and unboxing.

This module boxes lanes for Python, and unboxes the structure of a tuple.
"""

# mypy: disable-error-code="no-untyped-call,import-untyped,untyped-decorator"
# The compiler's own modules are untyped.

from typing import Any

from llvmlite import ir
from numba.extending import NativeValue, box, unbox

import layflat.jit.lanes.lowering
import layflat.jit.lanes.memory
import layflat.jit.lanes.tuples  # noqa: F401
from layflat.jit.internals import lower_constant
from layflat.jit.lanes.typing import LanesType, LikeType
from layflat.lanes import Lanes


@box(LanesType)
def _box_lanes(kind: Any, value: Any, c: Any) -> Any:
    """Return lanes of compiled code as the Python object `Lanes`."""
    places = [ir.Constant(ir.IntType(32), i) for i in range(kind.count)]
    numbers = [c.box(kind.leaf, c.builder.extract_element(value, place)) for place in places]
    together = c.pyapi.tuple_pack(numbers)
    lanes_class = c.pyapi.unserialize(c.pyapi.serialize_object(Lanes))
    lanes = c.pyapi.call_function_objargs(lanes_class, [together])
    for used in (*numbers, together, lanes_class):
        c.pyapi.decref(used)
    return lanes


@unbox(LikeType)
def _unbox_like(kind: Any, value: Any, c: Any) -> Any:  # noqa: ARG001  (the compiler's own interface)
    return NativeValue(c.context.get_dummy_value())


@lower_constant(LikeType)
def _like_constant(context: Any, builder: Any, kind: Any, value: Any) -> Any:  # noqa: ARG001  (the compiler's interface)
    return context.get_dummy_value()
